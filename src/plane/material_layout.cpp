// SPDX-License-Identifier: GPL-3.0-or-later
#include "plane/material_layout.h"

#include "plane/subdivision.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace crackle::plane {

namespace {

/// Corners this close to the line between their neighbours, relative to the body's size, do not bend it.
constexpr double straight = 1e-13;

/// The x at which regions begin or end, from 0 to the thickness.
std::vector<double> levels_of(const Specimen& specimen, double near) {
  std::vector<double> levels{0, specimen.size[0]};
  for (const MaterialRegion& region : specimen.regions)
    for (const double x : {region.box[0].first, region.box[0].second})
      if (x > 0 && x < specimen.size[0] &&
          std::ranges::none_of(levels, [&](double level) { return std::abs(level - x) <= near; }))
        levels.push_back(x);
  std::ranges::sort(levels);
  return levels;
}

/// The last of some regions that extends through a layer, or -1.
int last_of(const std::vector<int>& regions, const std::vector<std::uint8_t>& fills) {
  for (auto region = regions.rbegin(); region != regions.rend(); ++region)
    if (fills[index(*region)]) return *region;
  return -1;
}

/// The last region whose outline is this line, or -1.
int outlined_by(const Subdivision::Line& line) {
  std::vector<int> own;
  std::ranges::set_symmetric_difference(line.left, line.right, std::back_inserter(own));
  return own.empty() ? -1 : own.back();
}

/// Removes levels at which nothing changes.
void drop_levels(MaterialLayout& layout) {
  for (std::size_t level = layout.n_layers() - 1; level > 0; --level) {
    const auto same = [&](const std::vector<int>& regions) {
      return layout.material_of(regions[level - 1]) == layout.material_of(regions[level]);
    };
    if (!std::ranges::all_of(layout.lines, [&](const MaterialLayout::Line& line) {
          return same(line.left) && (line.side >= 0 || same(line.right));
        }))
      continue;
    const auto place = static_cast<std::ptrdiff_t>(level);
    layout.levels.erase(layout.levels.begin() + place);
    layout.fills.erase(layout.fills.begin() + place);
    for (MaterialLayout::Line& line : layout.lines) {
      line.left.erase(line.left.begin() + place);
      line.right.erase(line.right.begin() + place);
    }
  }
}

/// Joins two lines that continue each other straight, with the same materials on both sides.
class Joining {
public:
  Joining(MaterialLayout& layout, double size) : layout_(layout), near_(straight * size) {}

  void run() {
    std::map<int, std::vector<std::size_t>> at;
    for (std::size_t i = 0; i < layout_.lines.size(); ++i)
      for (const int end : layout_.lines[i].end) at[end].push_back(i);
    std::vector<std::uint8_t> is_gone(layout_.lines.size(), 0);
    for (auto& [corner, lines] : at) {
      if (lines.size() != 2 || !join(corner, lines[0], lines[1])) continue;
      is_gone[lines[1]] = 1;
      const auto& ends = layout_.lines[lines[0]].end;
      for (const int end : ends) std::ranges::replace(at[end], lines[1], lines[0]);
    }
    std::size_t i = 0;
    std::erase_if(layout_.lines, [&](const MaterialLayout::Line&) { return is_gone[i++] != 0; });
  }

private:
  /// Makes the first line reach to the other end of the second.
  bool join(int corner, std::size_t first, std::size_t second) {
    MaterialLayout::Line& a = layout_.lines[first];
    MaterialLayout::Line b = layout_.lines[second];
    if (a.side != b.side || first == second) return false;
    const bool a_begins = a.end[0] == corner;
    if ((b.end[0] == corner) == a_begins) {
      if (a.side >= 0) return false;  // at a corner of the plate
      std::swap(b.end[0], b.end[1]);
      std::swap(b.left, b.right);
    }
    const int far = a_begins ? b.end[0] : b.end[1];
    if (far == a.end[0] || far == a.end[1]) return false;
    if (!same(a.left, b.left) || (a.side < 0 && !same(a.right, b.right))) return false;
    const auto place = [&](int number) { return layout_.corners[index(number)]; };
    if (distance(place(corner), place(a.end[a_begins ? 1 : 0]), place(far)) > near_) return false;
    a.end[a_begins ? 0 : 1] = far;
    a.region = std::max(a.region, b.region);
    return true;
  }

  bool same(const std::vector<int>& a, const std::vector<int>& b) const {
    return std::ranges::equal(
        a, b, {}, [&](int region) { return layout_.material_of(region); },
        [&](int region) { return layout_.material_of(region); });
  }

  MaterialLayout& layout_;
  double near_;
};

}  // namespace

MaterialLayout material_layout(const Specimen& specimen, bool all) {
  const double size = std::ranges::max(specimen.size);
  const double near = region_merging * size;
  std::vector<Polygon> outlines;
  MaterialLayout layout;
  for (const MaterialRegion& region : specimen.regions) {
    outlines.push_back(region.outline);
    layout.material.push_back(region.number);
  }
  layout.levels = levels_of(specimen, near);
  for (std::size_t layer = 0; layer < layout.n_layers(); ++layer) {
    auto& fills = layout.fills.emplace_back();
    for (const MaterialRegion& region : specimen.regions)
      fills.push_back(region.box[0].first <= layout.levels[layer] + near &&
                      region.box[0].second >= layout.levels[layer + 1] - near);
  }
  Subdivision plane = subdivide(shape_of(specimen), outlines, near);
  for (const Subdivision::Line& line : plane.lines) {
    MaterialLayout::Line own{line.end, line.side, outlined_by(line), {}, {}};
    for (const auto& fills : layout.fills) {
      own.left.push_back(last_of(line.left, fills));
      own.right.push_back(last_of(line.right, fills));
    }
    bool matters = all || own.side >= 0;
    for (std::size_t layer = 0; layer < layout.n_layers(); ++layer)
      matters = matters || layout.is_wall(own, layer);
    if (matters) layout.lines.push_back(std::move(own));
  }
  layout.corners = std::move(plane.corners);
  layout.region = std::move(plane.figures);
  if (all) return layout;
  drop_levels(layout);
  Joining(layout, size).run();
  return layout;
}

}  // namespace crackle::plane
