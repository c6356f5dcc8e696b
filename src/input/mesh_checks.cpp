// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"
#include "dimension.h"
#include "input/parameters.h"
#include "input/poisson_limits.h"
#include "input/softening_limits.h"
#include "plane/subdivision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace crackle::input {

namespace {

/// Rounds to two significant digits, for advice.
double two_figures(double value, double (*round)(double)) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return round(value / unit) * unit;
}
double rounded_up(double value) {
  return two_figures(value, std::ceil);
}
double rounded_down(double value) {
  return two_figures(value, std::floor);
}

/// Area of the intersection of a shape and a box [m^2].
double common_area(const plane::Shape& shape, const plane::Region& box) {
  const plane::Bounds bounds = plane::bounds_of(shape.loops.front().corners);
  plane::Point lower{};
  plane::Point upper{};
  for (std::size_t i = 0; i < 2; ++i) {
    lower[i] = std::max(bounds.lower[i], box[i + 1].first);
    upper[i] = std::min(bounds.upper[i], box[i + 1].second);
    if (!(lower[i] < upper[i])) return 0;
  }
  return plane::common_area(shape, {lower, {upper[0], lower[1]}, upper, {lower[0], upper[1]}});
}

/// Volume of the body in a box [m^3]; of a solid an upper bound.
double material_volume(const plane::Specimen& specimen, const plane::Region& box) {
  if (specimen.solid) {
    double volume = 1;
    for (std::size_t i = 0; i < 3; ++i)
      volume *= std::min(box[i].second, specimen.solid->bounds[i].second) -
                std::max(box[i].first, specimen.solid->bounds[i].first);
    return std::min(volume, specimen.solid->volume);
  }
  const double thickness = std::min(box[0].second, specimen.size[0]) - std::max(box[0].first, 0.0);
  return std::max(0.0, thickness) * common_area(shape_of(specimen), box);
}

/// Rejects a spacing with too many points in a box: at least one per spacing^3; refinements elsewhere are
/// counted when the mesh is made.
void check_number(const Mesh& mesh, double spacing, double volume, const std::string& key,
                  Findings& findings) {
  const double n_points = volume / std::pow(spacing, 3);
  if (n_points <= max_mother_points || mesh.points) return;
  findings.report(key, "{} needs {:.0e} or more mother points, but the limit is {:.0e}; give at least {}",
                  show(spacing), n_points, max_mother_points,
                  show(rounded_up(std::cbrt(volume / max_mother_points))));
}

/// Rejects a mesh that is nowhere fine enough for softening.
void check_softening(const Parameters& parameters, Findings& findings) {
  const Fracture& fracture = parameters.fracture;
  if (!fracture.softens() || fracture.strength == 0 || fracture.toughness == 0) return;
  for (const char* const key : {"fracture.strength", "fracture.toughness", "fracture.softening", "material"})
    if (findings.faulty(key)) return;
  const Mesh& mesh = parameters.mesh;
  const double finest = mesh.finest_spacing();
  const double limit = snap_back_spacing(parameters);
  if (finest < limit || mesh.points) return;
  findings.report(
      "mesh.spacing",
      "the finest spacing, {}, is too coarse for softening: at the strength tetrahedra store more energy "
      "than the toughness dissipates, and snap back; where cracks run give less than {}, preferably {}",
      show(finest), show(rounded_down(limit)),
      show(rounded_down(resolving_share * process_zone_length(parameters))));
}

/// Spacings below this share of E G / (c strength^2), at which both thresholds are equal, are refused: with
/// thresholds at cracks of four times the strength, what is near a crack would break before it grows.
constexpr double finest_share = 0.07;

/// Rejects a mesh so fine that cracks cannot grow between tetrahedra of this strength.
void check_nucleation(const Parameters& parameters, Findings& findings) {
  if (parameters.mesh.points) return;
  for (const char* const key : {"fracture", "material"})
    if (findings.faulty(key)) return;
  const double finest = parameters.mesh.finest_spacing();
  for (std::size_t i = 0; i < parameters.materials.size(); ++i) {
    const Fracture fracture = parameters.fracture_of(i);
    if (!fracture.nucleates_by_means() || !fracture.separates_nucleation()) continue;
    const Material& material = parameters.materials[i];
    const double least =
        finest_share * material.youngs_modulus * fracture.toughness /
        (toughness_factor(fracture.release, material.poisson_ratio) * fracture.strength * fracture.strength);
    if (finest >= least) continue;
    findings.report(
        "mesh.spacing",
        "the finest spacing, {}, is below {}: tetrahedra at cracks would take more than four times "
        "the strength, so that others break before them; give at least {}, or fracture.length, "
        "the radius over which stresses are averaged",
        show(finest), show(least), show(rounded_up(least)));
    return;
  }
}

void check_region(const Parameters& parameters, std::size_t i, Findings& findings) {
  const MeshRegion& region = parameters.mesh.regions[i];
  const std::string key = fmt::format("mesh.region[{}]", i);
  if (!findings.given(key + ".x") && !findings.given(key + ".y") && !findings.given(key + ".z"))
    findings.report(key,
                    "has no bounds; give at least one of x, y and z, such as z = [\"60 mm\", \"80 mm\"]");
  if (!findings.faulty(key + ".spacing") && !findings.faulty("mesh.spacing") &&
      region.spacing > parameters.mesh.spacing)
    findings.report(key + ".spacing", "{} exceeds mesh.spacing; give at most {}", show(region.spacing),
                    show(parameters.mesh.spacing));
  if (findings.faulty(key) || !size_is_known(findings)) return;
  const Vector& size = parameters.specimen.size;
  const plane::Region bounds = bounds_of(parameters.specimen);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [lower, upper] = region.box[axis];
    const auto [first, last] = bounds[axis];
    if (lower < last && upper > first) continue;
    findings.report(fmt::format("{}.{}", key, axis_names[axis]),
                    fmt::format("the region from {} to {} is outside the body; give a range within {} to {}",
                                shown_length(lower), shown_length(upper),
                                first == 0 ? "0" : shown_length(first), shown_length(last)));
  }
  // In a solid, what a region contains is only known with the mesh.
  if (findings.faulty(key) || parameters.specimen.solid || !shape_is_known(parameters.specimen, findings))
    return;
  const double volume = material_volume(parameters.specimen, region.box);
  if (volume <= 1e-12 * size[0] * size[1] * size[2])
    findings.report(key, "lies {}, where there is no material; give a box in the body",
                    is_box(parameters.specimen) ? "in a notch" : "outside the body, in a notch or in a hole");
  else
    check_number(parameters.mesh, region.spacing, volume, key + ".spacing", findings);
}

}  // namespace

void check_mesh(const Parameters& parameters, Findings& findings) {
  const Mesh& mesh = parameters.mesh;
  for (std::size_t i = 0; i < mesh.regions.size(); ++i) check_region(parameters, i, findings);
  if (mesh.points && mesh.base == Base::own)
    findings.report("mesh.base",
                    "\"own\" generates points for each sample, but mesh.points reads them from a file; leave "
                    "one of the two out");
  if (findings.faulty("mesh.spacing")) return;
  if (!findings.faulty("mesh.notch_spacing") && mesh.notch_spacing > mesh.spacing) {
    findings.report("mesh.notch_spacing", "{} exceeds mesh.spacing; give at most {}",
                    show(mesh.notch_spacing), show(mesh.spacing));
  }
  if (!size_is_known(findings)) return;
  const Vector& size = parameters.specimen.size;
  const double smallest = *std::min_element(size.begin(), size.end());
  if (mesh.spacing > smallest) {
    findings.report("mesh.spacing", "{} exceeds the smallest edge of the body; give at most {}",
                    show(mesh.spacing), show(smallest));
    return;
  }
  if (!shape_is_known(parameters.specimen, findings)) return;
  check_number(mesh, mesh.spacing, material_volume(parameters.specimen, plane::everywhere), "mesh.spacing",
               findings);
  if (findings.faulty("mesh")) return;
  check_softening(parameters, findings);
  check_nucleation(parameters, findings);
}

}  // namespace crackle::input
