// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/model_limits.h"

#include "common/index.h"
#include "common/interpolation.h"
#include "common/quantity_text.h"
#include "geometry/mother_points.h"
#include "input/plausibility.h"
#include "mechanics/elasticity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace crackle::dynamics {

namespace {

using input::Boundary;
using input::BoundaryKind;

/// Extent of a plate, in thicknesses, from which out-of-plane bending matters.
constexpr double slender = 5;
/// Spacings through the thickness that resolve bending to about 15 %.
constexpr double resolving_cells = 4;
/// Poisson's ratio up to which the error due to locking is below a few percent.
constexpr double compressible = 0.4;
/// Range of the share of an end held by a plane of symmetry ahead of a crack: a support is smaller, a roller
/// along the whole end larger.
constexpr double least_ligament = 0.25, greatest_ligament = 0.98;
/// A mesh finer than every given spacing by this factor is probably a mistake.
constexpr double implausible_refinement = 50;
/// Displacement, as a share of the body's extent, with strains or rotations that are not small.
constexpr double large_displacement = 0.1;
/// Loading within this many wave transits is fast.
constexpr double few_transits = 5;

bool is_side(const Boundary& condition) {
  return condition.on == plane::face_names[0] || condition.on == plane::face_names[1];
}

bool covers(const Boundary& condition, const geometry::Box& box, std::size_t axis) {
  const double slack = 1e-9 * (box.upper[axis] - box.lower[axis]);
  const auto [lower, upper] = condition.region[axis];
  return lower <= box.lower[axis] + slack && upper >= box.upper[axis] - slack;
}

bool prescribes_motion(const Boundary& condition, std::size_t axis) {
  return input::prescribes_motion(condition.kind) && condition.components[axis];
}

/// True if a condition acts across the thickness of the plate.
bool acts_across(const Boundary& condition) {
  if (!input::has_quantity(condition.kind)) return false;
  const bool is_along_normal = input::traits(condition.kind).form == input::QuantityForm::scalar;
  return (!is_along_normal || is_side(condition)) && (condition.value[0] != 0 || condition.rate[0] != 0);
}

/// True if the same pressure acts on both sides of the plate, so that it does not bend.
bool is_balanced(const Boundary& one, const std::vector<Boundary>& all) {
  if (one.kind != BoundaryKind::pressure) return false;
  return std::ranges::any_of(all, [&](const Boundary& other) {
    return other.kind == BoundaryKind::pressure && is_side(other) && other.on != one.on &&
           other.value == one.value && other.rate == one.rate && other.history == one.history &&
           other.factor == one.factor && other.region[1] == one.region[1] && other.region[2] == one.region[2];
  });
}

/// Coarsest mesh spacing of the plate [m].
double greatest_spacing(const geometry::Body& body, const input::Mesh& mesh) {
  const geometry::SpacingField spacing(body, mesh);
  const geometry::Box& box = body.bounds();
  constexpr int n = 40;  // grid points in the plane along each axis
  double greatest = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const geometry::Point p{(box.lower[0] + box.upper[0]) / 2,
                              box.lower[1] + (i + 0.5) / n * (box.upper[1] - box.lower[1]),
                              box.lower[2] + (j + 0.5) / n * (box.upper[2] - box.lower[2])};
      if (body.contains(p)) greatest = std::max(greatest, spacing(p));
    }
  return greatest;
}

/// The first load that bends the plate, such as "boundary[1]"; empty if there is none.
std::string bending_load(const input::Model& model) {
  const auto& all = model.boundaries;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (acts_across(all[i]) && !is_balanced(all[i], all)) return fmt::format("boundary[{}]", i);
  // The centrifugal forces on the two halves of the thickness balance, or point along the plate.
  for (std::size_t i = 0; i < model.loads.size(); ++i)
    if (const input::BodyLoad& load = model.loads[i];
        !input::is_initial(load.kind) && (load.value[0] != 0 || load.rate[0] != 0))
      return fmt::format("load[{}]", i);
  return {};
}

std::string bending_warning(const input::Model& model, const geometry::Body& body) {
  const auto& all = model.boundaries;
  const Vector size = body.size();
  if (model.mesh.points || std::max(size[1], size[2]) < slender * size[0]) return {};
  const bool is_held_flat = std::ranges::any_of(all, [&](const Boundary& condition) {
    return is_side(condition) && prescribes_motion(condition, 0) && covers(condition, body.bounds(), 1) &&
           covers(condition, body.bounds(), 2);
  });
  if (is_held_flat) return {};
  const std::string bends = bending_load(model);
  if (bends.empty()) return {};
  const double cells = size[0] / greatest_spacing(body, model.mesh);
  if (!(cells < resolving_cells * (1 - 1e-6))) return {};
  return fmt::format(
      "{} loads the plate across its thickness of {:.4g} mm, which has {:.2g} cell{}: bending "
      "out of the plane is about {:.2g} times too stiff; use spacings of at most {:.3g} mm ({:.0f} cells: "
      "{:.3g} "
      "times)",
      bends, 1e3 * size[0], cells, std::abs(cells - 1) < 0.005 ? "" : "s", bending_stiffness_ratio(cells),
      1e3 * size[0] / resolving_cells, resolving_cells, bending_stiffness_ratio(resolving_cells));
}

/// As locking_load_ratio, where cracks start by own stress.
double own_stress_load_ratio(double poisson_ratio) {
  constexpr std::array<std::pair<double, double>, 5> measured{
      {{0.2, 1}, {0.4, 0.82}, {0.45, 0.7}, {0.49, 0.3}, {0.499, 0.08}}};
  return interpolated(measured, poisson_ratio);
}

std::string locking_warning(const input::Model& model) {
  const double nu = std::ranges::max(model.materials, {}, &input::Material::poisson_ratio).poisson_ratio;
  if (nu <= compressible) return {};
  std::string text = fmt::format(
      "at Poisson's ratio {:.4g} linear tetrahedra lock: in bending the body is about {:.3g} times too stiff "
      "with 10 cells over its height",
      nu, locking_stiffness_ratio(nu));
  if (model.fracture_of(0).strength > 0)
    text += fmt::format(
        ", and with fracture.strength a smooth beam breaks at about {:.2g} times its load",
        model.fracture_of(0).nucleates_by_means() ? locking_load_ratio(nu) : own_stress_load_ratio(nu));
  return text + fmt::format("; use a material.poisson_ratio of at most {:.2g}", compressible);
}

/// The end of the body, lower (0) or upper (1) along an axis, on whose plane faces a condition holds.
std::optional<std::pair<std::size_t, int>> end_of(const Boundary& condition, const geometry::Body& body) {
  std::optional<std::pair<std::size_t, int>> end;
  for (const auto id : body.faces_named(condition.on)) {
    const geometry::Face& face = body.faces()[index(id)];
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (std::abs(face.outward[axis]) < 1 - 1e-9) continue;
      const int side = face.outward[axis] > 0 ? 1 : 0;
      const double at = side == 1 ? body.bounds().upper[axis] : body.bounds().lower[axis];
      if (std::abs(face.patch.bounds().lower[axis] - at) > 1e-9 * body.size()[axis]) continue;
      if (end && *end != std::pair(axis, side)) return {};
      end = {axis, side};
    }
  }
  return end;
}

/// Length of the held part of an end, along the end [m].
double held_length(const Boundary& condition, const geometry::Body& body, std::size_t normal) {
  const std::size_t along = 3 - normal;
  double length = 0;
  for (const auto id : body.faces_named(condition.on)) {
    const geometry::Box box = body.faces()[index(id)].patch.bounds();
    const auto [lower, upper] = condition.region[along];
    length += std::max(0.0, std::min(upper, box.upper[along]) - std::max(lower, box.lower[along]));
  }
  return length;
}

/// Warns of an end that is held only along its normal next to a free part, like the ligament and the crack of
/// a half model.
std::string symmetry_warning(const input::Model& model, const geometry::Body& body) {
  const auto& all = model.boundaries;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].kind != BoundaryKind::fix) continue;
    const auto end = end_of(all[i], body);
    if (!end) continue;
    const auto normal = end->first;
    const std::size_t along = 3 - normal;
    if (!all[i].components[normal] || all[i].components[along] || !covers(all[i], body.bounds(), 0)) continue;
    const double share = held_length(all[i], body, normal) / body.size()[along];
    if (share < least_ligament || share > greatest_ligament) continue;
    // With other conditions on it, the end is a clamp, a drive or a support.
    const bool is_alone = std::ranges::none_of(all, [&](const Boundary& other) {
      return &other != &all[i] && end_of(other, body) == end &&
             (prescribes_motion(other, normal) || prescribes_motion(other, along));
    });
    if (!is_alone) continue;
    return fmt::format(
        "boundary[{}] constrains {:.0f} % of an end along {} only, like a symmetry plane ahead of a crack: a "
        "crack along such a plane needs about 1.4 times the load that it needs inside the body; model both "
        "halves",
        i, 100 * share, "xyz"[normal]);
  }
  return {};
}

/// Warns of a detail that makes the mesh far finer than any spacing given, like lines that nearly coincide.
std::string tiny_detail_warning(const input::Model& model, const geometry::Body& body) {
  if (model.mesh.points) return {};
  const geometry::SpacingField spacing(body, model.mesh);
  const geometry::SpacingSource* const detail = spacing.finest();
  const double given = model.mesh.finest_spacing();
  if (!detail || !(implausible_refinement * detail->spacing < given)) return {};
  return fmt::format(
      "{} makes the mesh as fine as {}, with {} as the finest spacing given, and may need millions of "
      "points; lines and corners that should coincide need equal coordinates",
      detail->reason, quantity_text(detail->spacing, "m"), quantity_text(given, "m"));
}

}  // namespace

double bending_stiffness_ratio(double cells) {
  // The excess stiffness, measured on cantilevers, falls with the square of the number of cells.
  constexpr std::array<std::pair<double, double>, 4> excess{{{1, 2.9}, {2, 2.8}, {3, 2.7}, {4, 2.56}}};
  return 1 + interpolated(excess, cells) / (cells * cells);
}

double locking_stiffness_ratio(double poisson_ratio) {
  constexpr std::array<std::pair<double, double>, 5> measured{
      {{0.2, 1.02}, {0.4, 1.05}, {0.45, 1.06}, {0.49, 1.14}, {0.499, 1.58}}};
  return interpolated(measured, poisson_ratio);
}

double locking_load_ratio(double poisson_ratio) {
  // Of four bars each with seven spacings over their height. Means around nodes smooth the pressure.
  constexpr std::array<std::pair<double, double>, 5> measured{
      {{0.2, 1}, {0.4, 0.97}, {0.45, 0.94}, {0.49, 0.81}, {0.499, 0.41}}};
  return interpolated(measured, poisson_ratio);
}

std::vector<std::string> model_warnings(const input::Study& study, const geometry::Body& body) {
  std::vector<std::string> warnings = input::plausibility_warnings(study);
  for (std::string text : {bending_warning(study, body), locking_warning(study),
                           symmetry_warning(study, body), tiny_detail_warning(study, body)})
    if (!text.empty()) warnings.push_back(std::move(text));
  return warnings;
}

std::string fast_loading_warning(input::Start start, double first_break_time, double transit) {
  if (start != input::Start::quasi_static) return {};
  if (!(first_break_time < few_transits * transit)) return {};
  return fmt::format(
      "quasi-static loading reaches the first break after {}, but a wave takes {} along the body, so inertia "
      "cannot be neglected; set time.start = \"rest\"",
      quantity_text(first_break_time, "s"), quantity_text(transit, "s"));
}

std::string large_displacement_warning(input::Start start, const Vector& size, double displacement) {
  if (start == input::Start::rest) return {};
  const double extent = std::ranges::max(size);
  const double share = std::abs(displacement) / extent;
  if (!(share > large_displacement)) return {};
  return fmt::format(
      "the peak load has moved by {}, {:.0f} % of the body's longest extent, but the program assumes small "
      "strains and rotations",
      quantity_text(std::abs(displacement), "m"), 100 * share);
}

}  // namespace crackle::dynamics
