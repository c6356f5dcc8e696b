// SPDX-License-Identifier: GPL-3.0-or-later
#include "condition_faces.h"
#include "consistency.h"
#include "dimension.h"
#include "document.h"
#include "kinds.h"
#include "solid_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace crackle::input {

namespace {

/// True if the limits include a part of an extent: more than its ends, except for a line, which may be one of
/// them.
bool meets(const std::pair<double, double>& limits, double lower, double upper) {
  if (limits.first == limits.second) return lower <= limits.first && limits.first <= upper;
  return limits.first < upper && limits.second > lower;
}

/// True if two intervals share more than an end; for a line, if it lies within the other interval or
/// coincides with it.
/// @param slack tolerance for ends, and for the two ends of a line
bool overlap(const std::pair<double, double>& one, const std::pair<double, double>& other, double slack) {
  const double first = std::max(one.first, other.first);
  const double last = std::min(one.second, other.second);
  if (last - first > slack) return true;
  const auto is_line = [&](const auto& interval) { return interval.second - interval.first <= slack; };
  const auto is_within = [&](const auto& line, const auto& part) {
    return line.first > part.first + slack && line.second < part.second - slack;
  };
  if (is_line(one) && is_line(other)) return first <= last;
  return (is_line(one) && is_within(one, other)) || (is_line(other) && is_within(other, one));
}

void check_course(const Boundary& condition, const std::string& key, Start start, Findings& findings) {
  const bool has_rate = findings.given(key + ".rate");
  const bool has_history = findings.given(key + ".history");
  if (condition.kind == BoundaryKind::fix && has_history) {
    findings.report(key + ".history",
                    "a fixed boundary does not change with time; give a displacement instead "
                    "of fix");
  } else if (condition.kind == BoundaryKind::absorbing && has_history) {
    findings.report(key + ".history", "an absorbing boundary does not change with time; leave it out");
  } else if (has_rate && has_history) {
    findings.report(key + ".history", "is given together with rate; give only one of the two");
  } else if (condition.kind == BoundaryKind::velocity && start != Start::rest && (has_rate || has_history)) {
    findings.report(key + (has_rate ? ".rate" : ".history"),
                    "a velocity that changes with time requires start = \"rest\": equilibria need "
                    "displacements that are piecewise linear in time; give a constant velocity, or a "
                    "displacement with a history");
  }
}

void check_factor(const Boundary& condition, const std::string& key, Findings& findings) {
  if (!condition.factor) return;
  if (!has_quantity(condition.kind)) {
    findings.report(key + ".factor", "{} has no value to multiply; leave it out", name_of(condition.kind));
    return;
  }
  for (const char* const part : {"along", "table"})
    if (const std::string path = fmt::format("{}.factor.{}", key, part); !findings.given(path))
      findings.report(
          path,
          "the key is missing; give factor = { along = \"y\", table = [[\"0 mm\", 0], [\"10 mm\", 1]] }");
}

/// A load per area needs a region with a width along the axes of a face.
void check_width(const Boundary& condition, std::size_t axis, const std::string& key, Findings& findings) {
  const auto& [lower, upper] = condition.region[axis];
  if (traits(condition.kind).by_area && lower == upper)
    findings.report(key + ".region." + axis_names[axis],
                    "a line or a point has no area for \"{}\"; give a force, or a wider region",
                    name_of(condition.kind));
}

void check_region_of_box(const Boundary& condition, plane::Face face, const std::string& key,
                         const plane::Specimen& specimen, Findings& findings) {
  const auto normal = static_cast<std::size_t>(axis_of(face));
  const double position = is_upper(face) ? specimen.size[normal] : 0;
  const auto [lower, upper] = condition.region[normal];
  const double tolerance = 1e-9 * specimen.size[normal];
  if (position < lower - tolerance || position > upper + tolerance) {
    findings.report(key + ".region." + axis_names[normal],
                    "the face lies at {} = {}, outside the region from {} to {}", axis_names[normal],
                    shown_length(position), shown_length(lower), shown_length(upper));
    return;
  }
  const plane::Region part = part_of_face(condition, face, specimen.size);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis != normal && !meets(condition.region[axis], 0, specimen.size[axis])) {
      findings.report(key + ".region." + axis_names[axis],
                      "the region from {} to {} misses the face; give a range within 0 to {}",
                      shown_length(condition.region[axis].first), shown_length(condition.region[axis].second),
                      shown_length(specimen.size[axis]));
      return;
    }
    if (axis != normal) check_width(condition, axis, key, findings);
  }
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) {
    const std::string notch = fmt::format("specimen.notch[{}]", i);
    if (specimen.notches[i].face != face || findings.faulty(notch)) continue;
    const plane::Region slot = slot_of(specimen.notches[i], bounds_of(specimen));
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // A line on the lip of the slot has nodes.
      const bool is_line = axis != normal && part[axis].first == part[axis].second;
      const double lip = is_line ? 1e-9 * specimen.size[axis] : 0;
      inside = inside && part[axis].first >= slot[axis].first + lip &&
               part[axis].second <= slot[axis].second - lip;
    }
    if (inside) {
      findings.report(key + ".region", "lies in the opening of {}, where the body has no face", notch);
    }
  }
}

/// "\"edge-0\" to \"edge-3\"": all numbered names of a kind.
std::string range_of_names(const char* kind, std::size_t n) {
  if (n == 0) return {};
  return n == 1 ? fmt::format(", \"{}-0\"", kind) : fmt::format(", \"{0}-0\" to \"{0}-{1}\"", kind, n - 1);
}

std::string known_names(const plane::Specimen& specimen, const std::vector<Wall>& walls) {
  const bool is_circle = specimen.outline && specimen.outline->polygon.empty();
  const std::size_t n_edges = !specimen.outline ? 4 : is_circle ? 1 : specimen.outline->polygon.size();
  std::string faces;
  for (const std::string name : plane::face_names)
    if (name[0] == 'x' || std::ranges::any_of(walls, [&](const Wall& wall) { return has_name(wall, name); }))
      faces += fmt::format("{}\"{}\"", faces.empty() ? "" : ", ", name);
  return faces + range_of_names("edge", n_edges) + range_of_names("hole", specimen.holes.size()) +
         range_of_names("notch", specimen.notches.size());
}

void check_region(const Boundary& condition, const std::string& key, const plane::Specimen& specimen,
                  const std::vector<Wall>& walls, Findings& findings) {
  if (specimen.solid) return check_region_of_solid(condition, key, *specimen.solid, findings);
  if (const auto face = box_face(condition, specimen))
    return check_region_of_box(condition, *face, key, specimen, findings);
  const plane::Region& region = condition.region;
  const double thickness = specimen.size[0];
  const bool is_side =
      condition.on == name_of(plane::Face::x_min) || condition.on == name_of(plane::Face::x_max);
  const double at = condition.on == name_of(plane::Face::x_max) ? thickness : 0;
  const bool is_beside =
      is_side ? region[0].first > at + 1e-9 * thickness || region[0].second < at - 1e-9 * thickness
              : !meets(region[0], 0, thickness);
  if (is_beside) {
    findings.report(key + ".region.x", "the region from {} to {} misses \"{}\"; give a range within 0 to {}",
                    shown_length(region[0].first), shown_length(region[0].second), condition.on,
                    shown_length(thickness));
    return;
  }
  for (const std::size_t axis : is_side ? std::vector<std::size_t>{1, 2} : std::vector<std::size_t>{0})
    check_width(condition, axis, key, findings);
  plane::Bounds bounds{{infinity, infinity}, {-infinity, -infinity}};
  bool is_known = is_side;
  bool is_met = false;
  for (const Wall& wall : walls) {
    if (!is_side && !has_name(wall, condition.on)) continue;
    is_known = true;
    is_met = is_met || share_in(wall, region);
    for (std::size_t i = 0; i < 2; ++i) {
      bounds.lower[i] = std::min({bounds.lower[i], wall.from[i], wall.to[i]});
      bounds.upper[i] = std::max({bounds.upper[i], wall.from[i], wall.to[i]});
    }
  }
  if (!is_known) {
    const bool is_end = std::ranges::find(plane::face_names, condition.on) != plane::face_names.end();
    findings.report(key + ".on", "{}; give one of {}",
                    is_end ? fmt::format("no edge of the outline lies at {}", condition.on)
                           : fmt::format("\"{}\" is not known", shortened(condition.on)),
                    known_names(specimen, walls));
    return;
  }
  if (is_side && !is_met) {
    // A part within the face; whether it lies in a hole is only known with the mesh.
    is_met = true;
    for (std::size_t i = 0; i < 2; ++i)
      is_met = is_met && meets(region[i + 1], bounds.lower[i], bounds.upper[i]);
  }
  if (!is_met)
    findings.report(key + ".region", "misses \"{}\"; give a range within y from {} to {} and z from {} to {}",
                    condition.on, shown_length(bounds.lower[0]), shown_length(bounds.upper[0]),
                    shown_length(bounds.lower[1]), shown_length(bounds.upper[1]));
}

/// True if two conditions act on a common part of a box's faces, or of its walls.
bool have_common_part(const Boundary& a, const Boundary& b, const plane::Specimen& specimen,
                      const std::vector<Wall>& walls) {
  if (specimen.solid) return have_common_part(a, b, *specimen.solid);
  const auto face = box_face(a, specimen);
  const auto other_face = box_face(b, specimen);
  if (face || other_face) {
    if (face != other_face) return false;
    const plane::Region part = part_of_face(a, *face, specimen.size);
    const plane::Region other = part_of_face(b, *face, specimen.size);
    const auto normal = static_cast<std::size_t>(axis_of(*face));
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (axis != normal && !overlap(part[axis], other[axis], 0)) return false;
    return true;
  }
  if (!overlap(a.region[0], b.region[0], 0) && a.on != name_of(plane::Face::x_min) &&
      a.on != name_of(plane::Face::x_max))
    return false;
  if (a.on.starts_with("x-") || b.on.starts_with("x-"))
    return a.on == b.on && overlap(a.region[1], b.region[1], 0) && overlap(a.region[2], b.region[2], 0);
  return std::ranges::any_of(walls, [&](const Wall& wall) {
    if (!has_name(wall, a.on) || !has_name(wall, b.on)) return false;
    const auto share = share_in(wall, a.region);
    const auto other = share_in(wall, b.region);
    // Regions may share a border, to which the tolerance gives some width; a line has no more than that.
    return share && other && overlap(*share, *other, 1e-6);
  });
}

/// Reports two conditions that prescribe the same component at the same points, unless both fix it.
void check_conflicts(const Parameters& parameters, std::size_t i, const std::vector<Wall>& walls,
                     Findings& findings) {
  const Boundary& condition = parameters.boundaries[i];
  for (std::size_t j = 0; j < i; ++j) {
    const Boundary& other = parameters.boundaries[j];
    if (findings.faulty(boundary_key(j)) || !prescribes_motion(other)) continue;
    if (condition.kind == BoundaryKind::fix && other.kind == BoundaryKind::fix) continue;
    std::vector<std::string> shared;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (condition.components[axis] && other.components[axis]) shared.emplace_back(axis_names[axis]);
    if (!shared.empty() && have_common_part(condition, other, parameters.specimen, walls)) {
      findings.report(
          boundary_key(i),
          "prescribes motion in {} at points where {} prescribes it too; prescribe each component once",
          fmt::join(shared, " and "), boundary_key(j));
      return;
    }
  }
}

/// Reports an absorbing face where another condition prescribes motion.
void check_absorbs(const Parameters& parameters, std::size_t i, const std::vector<Wall>& walls,
                   Findings& findings) {
  const Boundary& condition = parameters.boundaries[i];
  for (std::size_t j = 0; j < parameters.boundaries.size(); ++j) {
    const Boundary& other = parameters.boundaries[j];
    if (findings.faulty(boundary_key(j)) || !prescribes_motion(other)) continue;
    const bool is_free = std::ranges::find(other.components, false) != other.components.end();
    if ((is_free && other.kind == BoundaryKind::fix) ||
        !have_common_part(condition, other, parameters.specimen, walls))
      continue;
    findings.report(boundary_key(i),
                    "cannot absorb waves at points where {} prescribes the motion; leave one of the two out, "
                    "or fix only one or two components there",
                    boundary_key(j));
    return;
  }
}

void check_constrained_in_all_directions(const Parameters& parameters, Findings& findings) {
  std::vector<std::string> loose;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto is_constrained = std::ranges::any_of(parameters.boundaries, [&](const Boundary& condition) {
      return prescribes_motion(condition) && condition.components[axis];
    });
    if (!is_constrained) loose.emplace_back(axis_names[axis]);
  }
  if (loose.empty()) return;
  const bool absorbs = std::ranges::any_of(parameters.boundaries, [](const Boundary& condition) {
    return condition.kind == BoundaryKind::absorbing;
  });
  findings.report("boundary",
                  "no condition supports the body in {}{}, but start = \"{}\" needs equilibrium; give a fix, "
                  "displacement or velocity in each of x, y and z, or start = \"rest\"",
                  fmt::join(loose, " and "), absorbs ? " (an absorbing face carries no static load)" : "",
                  parameters.time.start == Start::equilibrium ? "equilibrium" : "quasi-static");
}

}  // namespace

void check_boundaries(const Parameters& parameters, Findings& findings) {
  if (parameters.boundaries.empty() && parameters.loads.empty() && parameters.tools.empty()) {
    if (!findings.faulty("boundary"))
      findings.report("boundary",
                      "the body has no boundary condition; give at least one [[boundary]], [[load]] or "
                      "[[tool]] table");
    return;
  }
  const plane::Specimen& specimen = parameters.specimen;
  const bool size_known =
      is_box(specimen) ? size_is_known(findings) : specimen.shape.has_value() || specimen.solid != nullptr;
  const std::vector<Wall> walls = size_known && !specimen.solid && !findings.faulty("specimen.notch")
                                      ? walls_of(shape_of(specimen))
                                      : std::vector<Wall>{};
  for (std::size_t i = 0; i < parameters.boundaries.size(); ++i) {
    const std::string key = boundary_key(i);
    const Boundary& condition = parameters.boundaries[i];
    check_kind(key, "boundary", kind_names, findings);
    if (findings.faulty(key)) continue;
    check_course(condition, key, parameters.time.start, findings);
    check_factor(condition, key, findings);
    if (condition.on.starts_with("notch-") && findings.faulty("specimen.notch")) continue;
    if (size_known) check_region(condition, key, specimen, walls, findings);
    if (size_known && prescribes_motion(condition) && !findings.faulty(key)) {
      check_conflicts(parameters, i, walls, findings);
    }
    if (size_known && condition.kind == BoundaryKind::absorbing && !findings.faulty(key))
      check_absorbs(parameters, i, walls, findings);
    if (size_known && !findings.faulty(key)) check_idle_load(parameters, i, walls, findings);
  }
  // Tools may support the body; the mesh tells where they touch it.
  if (parameters.time.start != Start::rest && parameters.tools.empty() && !findings.faulty("boundary") &&
      !findings.faulty("time.start")) {
    check_constrained_in_all_directions(parameters, findings);
  }
}

}  // namespace crackle::input
