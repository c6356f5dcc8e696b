// SPDX-License-Identifier: GPL-3.0-or-later
// Regions of materials: their outlines, and what can be wrong with them.
#include "consistency.h"
#include "dimension.h"
#include "figures.h"
#include "plane/material_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace crackle::input {

namespace {

using plane::Point;
using plane::Polygon;
using plane::operator+;
using plane::operator-;
using plane::operator*;

/// Regions with less than this share of the body's volume are none.
constexpr double no_volume = 1e-12;

std::string key_of(std::size_t i) {
  return fmt::format("specimen.region[{}]", i);
}

void check_keys(std::size_t i, Findings& findings) {
  const std::string key = key_of(i);
  const auto given = [&](const char* name) { return findings.given(key + "." + name); };
  const bool has_figure = given("radius") || given("semi_axes") || given("polygon");
  if (has_figure || given("center") || given("angle")) {
    check_figure(key, findings);
    for (const char* const name : {"y", "z"})
      if (given(name))
        findings.report(fmt::format("{}.{}", key, name),
                        "cannot be combined with radius, semi_axes or polygon; leave it out");
  } else if (!given("x") && !given("y") && !given("z")) {
    findings.report(key,
                    "has no shape; give a range of x, y or z, such as x = [\"0 mm\", \"2 mm\"], or one of "
                    "radius, semi_axes and polygon");
  }
}

void check_ranges(const Parameters& parameters, std::size_t i, Findings& findings) {
  const plane::Region bounds = bounds_of(parameters.specimen);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [lower, upper] = parameters.specimen.regions[i].box[axis];
    const auto [first, last] = bounds[axis];
    if (lower < last && upper > first) continue;
    findings.report(fmt::format("{}.{}", key_of(i), axis_names[axis]),
                    fmt::format("the region from {} to {} is outside the body; give a range within {} to {}",
                                shown_length(lower), shown_length(upper),
                                first == 0 ? "0" : shown_length(first), shown_length(last)));
  }
}

/// A rectangle. What reaches to an end of the body reaches beyond it.
Polygon rectangle(const plane::Region& box, const plane::Region& bounds, double near) {
  Point lower{}, upper{};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [first, last] = bounds[i + 1];
    const double beyond = (last - first) / 8;
    lower[i] = box[i + 1].first <= first + near ? first - beyond : box[i + 1].first;
    upper[i] = box[i + 1].second >= last - near ? last + beyond : box[i + 1].second;
  }
  return {lower, {upper[0], lower[1]}, upper, {lower[0], upper[1]}};
}

/// Makes the chords of curves end where they meet the surface or other regions, so that none is short.
void end_chords_at_meetings(plane::Specimen& specimen) {
  for (plane::MaterialRegion& region : specimen.regions) {
    if (!region.shape || !region.shape->polygon.empty()) continue;
    Polygon places;
    const auto add = [&](const Polygon& other) {
      const Polygon found = intersections(region.outline, other);
      places.insert(places.end(), found.begin(), found.end());
    };
    for (const plane::Loop& loop : shape_of(specimen).loops) add(loop.corners);
    for (const plane::MaterialRegion& other : specimen.regions)
      if (&other != &region) add(other.outline);
    Polygon stays;
    for (const Point& place : places) {
      insert_vertex(region.outline, place, stays);
      stays.push_back(place);
    }
  }
}

auto in_region(std::size_t layer, int region) {
  return [=](const plane::MaterialLayout::Line& line, bool on_left) {
    return plane::MaterialLayout::region_beside(line, on_left, layer) == region;
  };
}

/// Reports regions outside the body, and regions of which others leave nothing.
void check_volumes(const Parameters& parameters, const plane::MaterialLayout& layout, Findings& findings) {
  const plane::Specimen& specimen = parameters.specimen;
  const Vector& size = specimen.size;
  for (std::size_t i = 0; i < specimen.regions.size(); ++i) {
    if (specimen.regions[i].number == 0) continue;
    const int own = static_cast<int>(i);
    double visible = 0;
    for (std::size_t layer = 0; layer < layout.n_layers(); ++layer)
      visible += (layout.levels[layer + 1] - layout.levels[layer]) * layout.area(in_region(layer, own));
    if (visible > no_volume * size[0] * size[1] * size[2]) continue;
    plane::Specimen alone = specimen;
    alone.regions = {specimen.regions[i]};
    const plane::MaterialLayout without_others = material_layout(alone, true);
    double whole = 0;
    for (std::size_t layer = 0; layer < without_others.n_layers(); ++layer)
      whole += without_others.area(in_region(layer, 0));
    if (whole > no_volume * size[1] * size[2])
      findings.report(key_of(i), "is hidden by the regions after it; put it after them, or leave it out");
    else
      findings.report(key_of(i), "contains nothing of the body; give a place in it");
  }
}

/// The sharpest corner of a material at a boundary to another one, and the region there.
std::pair<plane::Corner, int> sharpest_corner(const plane::MaterialLayout& layout) {
  struct Arm {
    double angle;
    bool has_plate;  ///< to its left, seen from the corner
    int region;
  };
  std::map<int, std::vector<Arm>> arms;
  std::map<int, bool> is_inner;
  for (const plane::MaterialLayout::Line& line : layout.lines)
    for (std::size_t k = 0; k < 2; ++k) {
      const Point way = layout.corners[index(line.end[1 - k])] - layout.corners[index(line.end[k])];
      arms[line.end[k]].push_back({std::atan2(way[1], way[0]), line.side < 0 || k == 0, line.region});
      is_inner[line.end[k]] |= line.side < 0;
    }
  std::pair<plane::Corner, int> sharpest{{2 * std::numbers::pi, {}}, -1};
  for (auto& [corner, all] : arms) {
    if (!is_inner[corner]) continue;
    std::ranges::sort(all, {}, &Arm::angle);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!all[i].has_plate) continue;
      const Arm& next = all[(i + 1) % all.size()];
      const double angle = next.angle - all[i].angle + (i + 1 == all.size() ? 2 * std::numbers::pi : 0);
      if (angle < sharpest.first.angle)
        sharpest = {{angle, layout.corners[index(corner)]}, std::max(all[i].region, next.region)};
    }
  }
  return sharpest;
}

}  // namespace

void make_region_outlines(Parameters& parameters, Findings& findings) {
  plane::Specimen& specimen = parameters.specimen;
  for (std::size_t i = 0; i < specimen.regions.size(); ++i) {
    check_keys(i, findings);
    specimen.regions[i].number =
        std::max(0, material_named(parameters.materials, specimen.regions[i].material));
    if (!findings.faulty(key_of(i)) && size_is_known(findings)) check_ranges(parameters, i, findings);
  }
  if (findings.faulty("specimen") || !has_spacing(parameters, findings)) return;
  const plane::Region bounds = bounds_of(specimen);
  const ShapeBuilder figures(parameters);
  for (std::size_t i = 0; i < specimen.regions.size(); ++i) {
    plane::MaterialRegion& region = specimen.regions[i];
    if (!region.shape)
      region.outline = rectangle(region.box, bounds, plane::region_merging * std::ranges::max(specimen.size));
    else if (auto outline = figures.outline(*region.shape, key_of(i), fmt::format("region-{}", i), findings))
      region.outline = std::move(*outline);
    check_chords(key_of(i), region.outline, findings);
  }
}

void complete_regions(Parameters& parameters, Findings& findings) {
  plane::Specimen& specimen = parameters.specimen;
  if (specimen.regions.empty() || !has_spacing(parameters, findings) || !shape_is_known(specimen, findings))
    return;
  end_chords_at_meetings(specimen);
  check_volumes(parameters, material_layout(specimen, true), findings);
  if (findings.faulty("specimen.region")) return;
  const auto [corner, region] = sharpest_corner(material_layout(specimen));
  if (region >= 0)
    check_corner(corner,
                 fmt::format("the corner of {} at {}", key_of(index(region)), show_place(corner.place)),
                 parameters, findings);
}

}  // namespace crackle::input
