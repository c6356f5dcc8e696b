// SPDX-License-Identifier: GPL-3.0-or-later
// Where the materials of a body require a finer mesh.
#include "common/index.h"
#include "geometry/mother_points.h"

#include "plate.h"
#include "regions.h"
#include "tolerances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace crackle::geometry {

namespace {

using Line = plane::MaterialLayout::Line;

/// Maximum number of pieces of a wall for measuring its distance to others.
constexpr double most_wall_pieces = 1000;

bool share_an_end(const Line& a, const Line& b) {
  return a.end[0] == b.end[0] || a.end[0] == b.end[1] || a.end[1] == b.end[0] || a.end[1] == b.end[1];
}

class RegionSpacing {
public:
  RegionSpacing(const plane::Specimen& specimen, plane::MaterialLayout layout) : layout_(std::move(layout)) {
    for (const plane::MaterialRegion& region : specimen.regions)
      is_curve_.push_back(region.shape && region.shape->polygon.empty());
  }

  void add_sources(const Box& bounds, const input::Mesh& mesh, std::vector<SpacingSource>& sources) const {
    add_wall_sources(bounds, mesh, sources);
    add_cap_sources(bounds, mesh, sources);
  }

private:
  std::string region_name(std::size_t line) const {
    return fmt::format("specimen.region[{}]", layout_.lines[line].region);
  }

  /// The length of each wall, and the distance of others and of the surface to pieces of it.
  void add_wall_sources(const Box& bounds, const input::Mesh& mesh,
                        std::vector<SpacingSource>& sources) const {
    std::vector<SpacingSource> given = region_sources(mesh, bounds);
    given.insert(given.end(), sources.begin(), sources.end());
    const auto& lines = layout_.lines;
    std::vector<plane::Side> sides;
    for (std::size_t i = 0; i < lines.size(); ++i) sides.push_back(side_of(layout_, lines[i]));
    const auto is_curve = [&](const Line& line) { return line.region >= 0 && is_curve_[index(line.region)]; };
    int curve = -1;
    std::size_t own_curve = 0;  // the first source of a chord's curve
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].side >= 0) continue;
      double lower = bounds.upper[0], upper = 0;
      for (std::size_t layer = 0; layer < layout_.n_layers(); ++layer)
        if (layout_.is_wall(lines[i], layer)) {
          lower = std::min(lower, layout_.levels[layer]);
          upper = std::max(upper, layout_.levels[layer + 1]);
        }
      if (const int now = is_curve(lines[i]) ? lines[i].region : -1; now != curve) {
        curve = now;
        own_curve = sources.size();
      }
      const auto add_if_finer = [&](double wanted, const plane::Point& from, const plane::Point& to,
                                    const char* what) {
        const Point middle{(lower + upper) / 2, (from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
        double spacing = mesh.spacing;
        for (const SpacingSource& source : given) spacing = std::min(spacing, source.at(middle));
        for (std::size_t k = own_curve; curve >= 0 && k < sources.size(); ++k)
          spacing = std::min(spacing, sources[k].at(middle));
        if (!(wanted * fine_enough < spacing)) return;
        Box box{{lower, from[0], from[1]}, {upper, from[0], from[1]}};
        box.include({upper, to[0], to[1]});
        sources.push_back(
            {box, wanted, shape_growth(mesh), fmt::format("the {} of {}", what, region_name(i))});
        if (from[0] != to[0] && from[1] != to[1]) sources.back().wall = {from, to};
      };
      add_if_finer(sides[i].length, sides[i].from, sides[i].to, "length of a side");
      const auto faces = [&](std::size_t other) {
        return other != i && !share_an_end(lines[i], lines[other]) &&
               !(curve >= 0 && curve == lines[other].region && lines[other].side < 0);
      };
      const double n_pieces = std::clamp(std::ceil(sides[i].length / mesh.spacing), 1.0, most_wall_pieces);
      for (double piece = 0; piece < n_pieces; ++piece) {
        const auto place = [&](double number) {
          const double arc_length = number / n_pieces * sides[i].length;
          return plane::Point{sides[i].from[0] + arc_length * sides[i].along[0],
                              sides[i].from[1] + arc_length * sides[i].along[1]};
        };
        const plane::Point from = place(piece);
        const plane::Point to = place(piece + 1);
        double gap = mesh.spacing;
        for (std::size_t other = 0; other < lines.size(); ++other)
          if (faces(other))
            gap = std::min(gap, plane::distance(from, to, sides[other].from, sides[other].to));
        add_if_finer(gap, from, to, "gap beside or width");
      }
    }
  }

  /// The distance along x between a cap of a region and others over it, or the surface.
  void add_cap_sources(const Box& bounds, const input::Mesh& mesh,
                       std::vector<SpacingSource>& sources) const {
    for (std::size_t region = 0; region < layout_.region.size(); ++region) {
      const plane::Bounds own = plane::bounds_of(layout_.region[region]);
      std::vector<double> levels;
      for (std::size_t level = 0; level <= layout_.n_layers(); ++level) {
        const bool below = level > 0 && layout_.fills[level - 1][region];
        const bool above = level < layout_.n_layers() && layout_.fills[level][region];
        if (below != above && level > 0 && level < layout_.n_layers())
          levels.push_back(layout_.levels[level]);
      }
      for (const double x : levels)
        for (std::size_t level = 0; level <= layout_.n_layers(); ++level) {
          const double other = layout_.levels[level];
          const double gap = std::abs(other - x);
          if (gap == 0 || !(gap * fine_enough < mesh.spacing)) continue;
          Box box{{std::min(x, other), own.lower[0], own.lower[1]},
                  {std::max(x, other), own.upper[0], own.upper[1]}};
          for (std::size_t i = 1; i < 3; ++i) {
            box.lower[i] = std::max(box.lower[i], bounds.lower[i]);
            box.upper[i] = std::min(box.upper[i], bounds.upper[i]);
          }
          const bool at_surface = level == 0 || level == layout_.n_layers();
          const auto touches = [&](const Line& line) {
            const bool is_rim =
                is_in_cap(layout_, line, level, true) != is_in_cap(layout_, line, level, false);
            const plane::Side side = side_of(layout_, line);
            return is_rim && distance(box, Edge(at(x, side.from), at(x, side.to)).bounds()) <= gap;
          };
          const bool is_covered = at_surface || std::ranges::any_of(layout_.lines, touches);
          if (is_covered)
            sources.push_back(
                {box, gap, shape_growth(mesh),
                 fmt::format("the thickness of specimen.region[{}], or above or below it", region)});
        }
    }
  }

  plane::MaterialLayout layout_;
  std::vector<bool> is_curve_;  ///< of each region
};

}  // namespace

SpacingRule region_spacing(const plane::Specimen& specimen, const plane::MaterialLayout& layout) {
  return [spacing = std::make_shared<const RegionSpacing>(specimen, layout)](
             const Body& body, const input::Mesh& mesh, std::vector<SpacingSource>& sources) {
    spacing->add_sources(body.bounds(), mesh, sources);
  };
}

}  // namespace crackle::geometry
