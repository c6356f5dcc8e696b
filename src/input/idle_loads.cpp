// SPDX-License-Identifier: GPL-3.0-or-later
// Loads where motions are prescribed, which the body does not feel.
#include "condition_faces.h"
#include "consistency.h"
#include "dimension.h"
#include "solid_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace crackle::input {

namespace {

using plane::operator-;

/// An overlap by a smaller share of a load's area may be meant: of a load with the support beside it.
constexpr double slight_overlap = 0.05;

/// The part of an interval that is in another one, from 0 to 1; of a line 0 or 1.
double share_within(const std::pair<double, double>& part, const std::pair<double, double>& other) {
  const double length = part.second - part.first;
  const double first = std::max(part.first, other.first);
  const double last = std::min(part.second, other.second);
  if (length > 0) return std::max(0.0, last - first) / length;
  return first <= last ? 1 : 0;
}

/// The share of the area on which a load acts that is also a motion's; of a line the share of its length.
/// Notches and holes in a face are neglected.
double share_driven(const Boundary& load, const Boundary& motion, const plane::Specimen& specimen,
                    const std::vector<Wall>& walls) {
  if (specimen.solid) return share_driven(load, motion, *specimen.solid);
  const auto face = box_face(load, specimen);
  const bool is_side = load.on.starts_with("x-");
  if (face || is_side) {
    if (face ? face != box_face(motion, specimen) : load.on != motion.on) return 0;
    const plane::Face of =
        face.value_or(load.on == name_of(plane::Face::x_min) ? plane::Face::x_min : plane::Face::x_max);
    const plane::Region part = part_of_face(load, of, specimen.size);
    const plane::Region other = part_of_face(motion, of, specimen.size);
    double share = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) share *= share_within(part[axis], other[axis]);
    return share;
  }
  double all = 0, common = 0;
  for (const Wall& wall : walls) {
    const auto part = has_name(wall, load.on) ? share_in(wall, load.region) : std::nullopt;
    if (!part) continue;
    const double length = plane::norm(wall.to - wall.from);
    all += length * (part->second - part->first);
    if (const auto other = has_name(wall, motion.on) ? share_in(wall, motion.region) : std::nullopt)
      common += length * (part->second - part->first) * share_within(*part, *other);
  }
  const auto across = [&](const Boundary& condition) {
    return std::pair{std::max(condition.region[0].first, 0.0),
                     std::min(condition.region[0].second, specimen.size[0])};
  };
  return all > 0 ? common / all * share_within(across(load), across(motion)) : 0;
}

/// The axes along which a load acts.
std::array<bool, 3> axes_of_load(const Boundary& load, const plane::Specimen& specimen,
                                 const std::vector<Wall>& walls) {
  std::array<bool, 3> acts{};
  if (load.kind != BoundaryKind::pressure) {
    for (std::size_t axis = 0; axis < 3; ++axis) acts[axis] = load.value[axis] != 0 || load.rate[axis] != 0;
    return acts;
  }
  if (load.value[0] == 0 && load.rate[0] == 0) return acts;
  if (specimen.solid) {
    for (const solid::Face& face : specimen.solid->faces)
      if (std::ranges::find(face.names, load.on) != face.names.end())
        for (std::size_t axis = 0; axis < 3; ++axis)
          acts[axis] = acts[axis] || std::abs(face.outward[axis]) > 1e-9;
    return acts;
  }
  if (load.on.starts_with("x-")) return {true, false, false};
  for (const Wall& wall : walls) {
    if (!has_name(wall, load.on)) continue;
    const plane::Point way = wall.to - wall.from;
    acts[1] = acts[1] || std::abs(way[1]) > 1e-9 * plane::norm(way);
    acts[2] = acts[2] || std::abs(way[0]) > 1e-9 * plane::norm(way);
  }
  return acts;
}

/// A load where conditions prescribe motion in its direction: there it acts on the support or drive only.
struct IdleLoad {
  double share = 0;        ///< of the load, at most that of one condition
  std::size_t motion = 0;  ///< number of that condition
  std::size_t axis = 0;
  bool is_all = true;  ///< along every axis on which the load acts
};

std::optional<IdleLoad> idle_load(const Model& model, std::size_t i, const std::vector<Wall>& walls) {
  const Boundary& load = model.boundaries[i];
  if (traits(load.kind).action != Action::load) return {};
  IdleLoad idle;
  const auto acts = axes_of_load(load, model.specimen, walls);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!acts[axis]) continue;
    double greatest = 0;
    for (std::size_t j = 0; j < model.boundaries.size(); ++j) {
      const Boundary& motion = model.boundaries[j];
      if (!prescribes_motion(motion) || !motion.components[axis]) continue;
      const double share = share_driven(load, motion, model.specimen, walls);
      if (share > idle.share) idle = {share, j, axis, idle.is_all};
      greatest = std::max(greatest, share);
    }
    idle.is_all = idle.is_all && greatest > 1 - 1e-6;
  }
  return idle.share > 0 ? std::optional(idle) : std::nullopt;
}

}  // namespace

void check_idle_load(const Model& model, std::size_t i, const std::vector<Wall>& walls, Findings& findings) {
  const auto idle = idle_load(model, i, walls);
  if (!idle || !idle->is_all || findings.faulty(boundary_key(idle->motion))) return;
  findings.report(boundary_key(i),
                  "its {} acts only where {} prescribes the motion in {}, so that the body does not feel it; "
                  "leave one of the two out, or move it",
                  name_of(model.boundaries[i].kind), boundary_key(idle->motion), axis_names[idle->axis]);
}

std::vector<std::string> idle_load_warnings(const Model& model) {
  const std::vector<Wall> walls =
      model.specimen.solid ? std::vector<Wall>{} : walls_of(shape_of(model.specimen));
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < model.boundaries.size(); ++i)
    if (const auto idle = idle_load(model, i, walls); idle && idle->share > slight_overlap)
      warnings.push_back(fmt::format(
          "{:.0f} % of the {} of {} act where {} prescribes the motion in {}, so that the body does not feel "
          "them along that axis; separate the two",
          100 * idle->share, name_of(model.boundaries[i].kind), boundary_key(i), boundary_key(idle->motion),
          axis_names[idle->axis]));
  return warnings;
}

}  // namespace crackle::input
