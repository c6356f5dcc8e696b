// SPDX-License-Identifier: GPL-3.0-or-later
// Spacing sources and symmetries of a body of several materials.
#include "crackle/common/index.h"
#include "crackle/geometry/mother_points.h"

#include "composite_body.h"
#include "reflection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::geometry {

namespace {

using Line = input::MaterialLayout::Line;

/// Maximum number of pieces of a wall for measuring its distance to others.
constexpr double most_wall_pieces = 1000;
/// Places this far from a boundary, relative to the body's size, are off it, and beside it.
constexpr double beside = 1e-7;

bool share_an_end(const Line& a, const Line& b) {
  return a.end[0] == b.end[0] || a.end[0] == b.end[1] || a.end[1] == b.end[0] || a.end[1] == b.end[1];
}

}  // namespace

std::vector<SpacingSource> CompositeBody::spacing_sources(const input::Mesh& mesh) const {
  std::vector<SpacingSource> sources = plain_->spacing_sources(mesh);
  add_wall_sources(mesh, sources);
  add_cap_sources(mesh, sources);
  return sources;
}

std::string CompositeBody::region_name(std::size_t line) const {
  return fmt::format("specimen.region[{}]", layout_.lines[line].region);
}

/// The length of each wall, and the distance of others and of the surface to pieces of it.
void CompositeBody::add_wall_sources(const input::Mesh& mesh, std::vector<SpacingSource>& sources) const {
  std::vector<SpacingSource> given = region_sources(mesh, bounds());
  given.insert(given.end(), sources.begin(), sources.end());
  const auto& lines = layout_.lines;
  std::vector<plane::Side> sides;
  for (std::size_t i = 0; i < lines.size(); ++i) sides.push_back(side_of(lines[i], i));
  const auto is_curve = [&](const Line& line) { return line.region >= 0 && is_curve_[index(line.region)]; };
  int curve = -1;
  std::size_t own_curve = 0;  // the first source of a chord's curve
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].side >= 0) continue;
    double lower = bounds().upper[0], upper = 0;
    for (std::size_t layer = 0; layer < layers_.size(); ++layer)
      if (layout_.is_wall(lines[i], layer)) {
        lower = std::min(lower, layers_[layer].lower);
        upper = std::max(upper, layers_[layer].upper);
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
      sources.push_back({box, wanted, shape_growth(mesh), fmt::format("the {} of {}", what, region_name(i))});
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
        if (faces(other)) gap = std::min(gap, plane::distance(from, to, sides[other].from, sides[other].to));
      add_if_finer(gap, from, to, "gap beside or width");
    }
  }
}

/// The distance along x between a cap of a region and others over it, or the surface.
void CompositeBody::add_cap_sources(const input::Mesh& mesh, std::vector<SpacingSource>& sources) const {
  const double thickness = bounds().upper[0];
  for (std::size_t region = 0; region < outlines_.size(); ++region) {
    const plane::Bounds& own = outlines_[region].bounds;
    std::vector<double> levels;
    for (std::size_t level = 0; level <= layers_.size(); ++level) {
      const bool below = level > 0 && layout_.fills[level - 1][region];
      const bool above = level < layers_.size() && layout_.fills[level][region];
      if (below != above && level > 0 && level < layers_.size()) levels.push_back(layout_.levels[level]);
    }
    for (const double x : levels)
      for (const double other : layout_.levels) {
        const double gap = std::abs(other - x);
        if (gap == 0 || !(gap * fine_enough < mesh.spacing)) continue;
        Box box{{std::min(x, other), own.lower[0], own.lower[1]},
                {std::max(x, other), own.upper[0], own.upper[1]}};
        for (std::size_t i = 1; i < 3; ++i) {
          box.lower[i] = std::max(box.lower[i], bounds().lower[i]);
          box.upper[i] = std::min(box.upper[i], bounds().upper[i]);
        }
        const bool at_surface = other == 0 || other == thickness;
        const bool is_covered =
            at_surface || std::ranges::any_of(caps_, [&](const Cap& cap) {
              return cap.x == other && std::ranges::any_of(cap.rim.sides(), [&](const plane::Side& side) {
                       return distance(box, Edge({x, side.from[0], side.from[1]}, {x, side.to[0], side.to[1]})
                                                .bounds()) <= gap;
                     });
            });
        if (is_covered)
          sources.push_back(
              {box, gap, shape_growth(mesh),
               fmt::format("the thickness of specimen.region[{}], or above or below it", region)});
      }
  }
}

/// True if a symmetry maps inner faces onto inner faces and materials onto themselves.
bool CompositeBody::maps_materials(const Symmetry& symmetry) const {
  const double near = 4 * tolerance_;
  const double off = beside * std::ranges::max(size());
  const auto image_of = [&](double x, const plane::Point& p) { return symmetry.image({x, p[0], p[1]}); };
  const auto are_near = [&](const Point& a, const plane::Point& b) {
    return std::abs(a[1] - b[0]) <= near && std::abs(a[2] - b[1]) <= near;
  };
  const auto has_side = [&](const plane::SideIndex& all, const Point& from, const Point& to) {
    return std::ranges::any_of(all.sides(), [&](const plane::Side& side) {
      return (are_near(from, side.from) && are_near(to, side.to)) ||
             (are_near(from, side.to) && are_near(to, side.from));
    });
  };
  const auto keeps_materials = [&](double x, const plane::Side& side) {
    const plane::Point middle{(side.from[0] + side.to[0]) / 2, (side.from[1] + side.to[1]) / 2};
    for (const double arc_length : {-off, off}) {
      const Point p{x, middle[0] - arc_length * side.along[1], middle[1] + arc_length * side.along[0]};
      if (plain_->contains(p) && material_at(p) != material_at(symmetry.image(p))) return false;
    }
    return true;
  };
  for (const Layer& layer : layers_) {
    const double x = (layer.lower + layer.upper) / 2;
    const double low = image_of(layer.lower, {})[0];
    const double high = image_of(layer.upper, {})[0];
    const auto other = std::ranges::find_if(layers_, [&](const Layer& one) {
      return std::abs(one.lower - std::min(low, high)) <= near &&
             std::abs(one.upper - std::max(low, high)) <= near;
    });
    if (other == layers_.end()) return false;
    for (const plane::Side& side : layer.walls.sides())
      if (!has_side(other->walls, image_of(x, side.from), image_of(x, side.to)) || !keeps_materials(x, side))
        return false;
  }
  return std::ranges::all_of(caps_, [&](const Cap& cap) {
    const double image = image_of(cap.x, {})[0];
    const auto other =
        std::ranges::find_if(caps_, [&](const Cap& one) { return std::abs(one.x - image) <= near; });
    return other != caps_.end() && std::ranges::all_of(cap.borders.sides(), [&](const plane::Side& side) {
             return has_side(other->borders, image_of(cap.x, side.from), image_of(cap.x, side.to)) &&
                    keeps_materials(cap.x - off, side) && keeps_materials(cap.x + off, side);
           });
  });
}

/// Those symmetries of the plate, with images moved onto inner faces if close.
std::vector<Symmetry> CompositeBody::symmetries() const {
  std::array<std::vector<double>, 3> planes;
  for (const Cap& cap : caps_) planes[0].push_back(cap.x);
  for (const Layer& layer : layers_)
    for (const plane::Side& side : layer.walls.sides())
      for (std::size_t i = 0; i < 2; ++i)
        if (side.along[i] == 0) planes[i + 1].push_back(side.from[i]);
  for (auto& positions : planes) {
    std::ranges::sort(positions);
    positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
  }
  const auto moved = [planes, near = tolerance_](const std::function<Point(const Point&)>& map) {
    return [=](const Point& p) {
      Point image = map(p);
      for (std::size_t i = 0; i < 3; ++i) {
        const auto plane = std::ranges::lower_bound(planes[i], image[i] - near);
        if (plane != planes[i].end() && *plane <= image[i] + near) image[i] = *plane;
      }
      return image;
    };
  };
  std::vector<Symmetry> result;
  for (Symmetry& symmetry : plain_->symmetries()) {
    if (symmetry.code != 0) {
      symmetry.image = moved(symmetry.image);
      symmetry.preimage = moved(symmetry.preimage);
      if (!maps_materials(symmetry)) continue;
    }
    result.push_back(std::move(symmetry));
  }
  return result;
}

}  // namespace crackle::geometry
