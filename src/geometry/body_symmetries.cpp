// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "geometry/body.h"

#include "tolerances.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace crackle::geometry {

namespace {

/// Images of corners are this many tolerances away from corners at most.
constexpr double image_tolerances = 4;
/// Places this far from a face, relative to the body's size, are off it, and beside it.
constexpr double beside = 1e-7;

/// Reflects coordinate i about the middle of a box if bit i of `axes` is set: two bits together are a
/// half-turn, three a reflection in the centre. It is its own inverse.
struct Reflection {
  unsigned axes;
  Box box;
  std::array<std::vector<double>, 3> planes;  ///< positions of the faces normal to each axis, ascending
  double near;                                ///< [m]

  /// Moved onto a plane of the body if close.
  Point operator()(const Point& p) const {
    Point q = p;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!((axes >> i) & 1u)) continue;
      q[i] = box.upper[i] - p[i] + box.lower[i];
      const auto plane = std::ranges::lower_bound(planes[i], q[i] - near);
      if (plane != planes[i].end() && *plane <= q[i] + near) q[i] = *plane;
    }
    return q;
  }

  std::string name() const {
    std::vector<char> names;
    for (unsigned i = 0; i < 3; ++i)
      if ((axes >> i) & 1u) names.push_back("xyz"[i]);
    return names.empty() ? "as it is"
                         : fmt::format("reflected in the middle of {}", fmt::join(names, " and "));
  }
};

}  // namespace

/// The image of a body by a reflection, part by part.
class Body::Image {
public:
  Image(const Body& body, const std::function<Point(const Point&)>& reflection)
      : body_(body), reflection_(reflection), near_(image_tolerances * body.tolerance_) {
    for (std::size_t i = 0; i < body.corners().size(); ++i)
      by_height_.emplace_back(height(body.corners()[i]), static_cast<std::int32_t>(i));
    std::ranges::sort(by_height_);
    for (std::size_t e = 0; e < body.edges().size(); ++e)
      edges_.emplace(ends(e), static_cast<std::int32_t>(e));
  }

  /// The image of each crack start; empty if the body is not its own image.
  std::optional<std::vector<std::int32_t>> crack_starts() {
    if (!maps_corners() || !maps_edges() || !maps_faces() || !keeps_materials()) return {};
    std::vector<std::int32_t> start_of(body_.faces().size(), -1);
    const std::vector<CrackStart>& starts = body_.crack_starts();
    std::vector<std::int32_t> images(starts.size(), -1);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (starts[i].is_free_surface) images[i] = static_cast<std::int32_t>(i);
      if (starts[i].is_pre_crack && (images[i] = image_of(starts[i].border)) < 0) return {};
      for (const FaceId face : starts[i].faces) start_of[index(face)] = static_cast<std::int32_t>(i);
    }
    for (std::size_t face = 0; face < start_of.size(); ++face) {
      const std::int32_t from = start_of[face];
      const std::int32_t to = start_of[index(face_[face])];
      if ((from < 0) != (to < 0)) return {};
      if (from < 0) continue;
      std::int32_t& image = images[index(from)];
      if (image >= 0 && image != to) return {};
      image = to;
    }
    return images;
  }

private:
  /// The pre-crack whose border is the image of this one, or -1.
  std::int32_t image_of(const std::vector<Point>& border) const {
    const std::vector<CrackStart>& starts = body_.crack_starts();
    const auto found = std::ranges::find_if(starts, [&](const CrackStart& other) {
      return other.is_pre_crack && other.border.size() == border.size() &&
             std::ranges::all_of(border, [&](const Point& mark) {
               const Point there = reflection_(mark);
               return std::ranges::any_of(other.border,
                                          [&](const Point& p) { return norm(p - there) <= near_; });
             });
    });
    return found == starts.end() ? -1 : static_cast<std::int32_t>(found - starts.begin());
  }

  using Ends = std::pair<std::int32_t, std::int32_t>;

  /// A coordinate along a direction in which hardly any two corners agree.
  static double height(const Point& p) {
    return (p[0] + std::numbers::e * p[1] + std::numbers::pi * p[2]) / 8;
  }

  Ends ends(std::size_t edge) const { return std::minmax(body_.ends_[edge].from, body_.ends_[edge].to); }

  std::int32_t corner_at(const Point& p) const {
    const auto at = std::ranges::lower_bound(by_height_, std::pair(height(p) - near_, std::int32_t{-1}));
    for (auto entry = at; entry != by_height_.end() && entry->first <= height(p) + near_; ++entry)
      if (norm(body_.corners()[index(entry->second)] - p) <= near_) return entry->second;
    return -1;
  }

  bool maps_corners() {
    for (const Point& corner : body_.corners()) corner_.push_back(corner_at(reflection_(corner)));
    return std::ranges::find(corner_, -1) == corner_.end();
  }

  bool maps_edges() {
    for (std::size_t e = 0; e < body_.edges().size(); ++e) {
      const auto [from, to] = ends(e);
      if (from < 0) return false;
      const auto found = edges_.find(std::minmax(corner_[index(from)], corner_[index(to)]));
      if (found == edges_.end()) return false;
      edge_.push_back(found->second);
    }
    return true;
  }

  /// A face is the image of another one if it has the images of all edges of that one's border.
  bool maps_faces() {
    std::vector<std::vector<FaceId>> possible(body_.n_meshed_faces());
    std::vector<std::uint8_t> is_begun(body_.n_meshed_faces(), 0);
    for (std::size_t e = 0; e < edge_.size(); ++e)
      for (const FaceId face : body_.at_edge_[e].faces) {
        std::vector<FaceId> there = body_.at_edge_[index(edge_[e])].faces;
        auto& left = possible[index(face)];
        if (is_begun[index(face)])
          std::erase_if(left, [&](FaceId one) { return std::ranges::find(there, one) == there.end(); });
        else
          left = std::move(there);
        is_begun[index(face)] = 1;
      }
    const auto is_inner = [&](FaceId face) { return index(face) >= body_.faces().size(); };
    for (std::size_t face = 0; face < possible.size(); ++face) {
      if (possible[face].empty() || is_inner(possible[face].front()) != is_inner(static_cast<FaceId>(face)))
        return false;
      face_.push_back(possible[face].front());
    }
    return true;
  }

  /// Compares the materials on both sides of inner faces, beside each piece of their borders.
  bool keeps_materials() const {
    const double off = beside * std::ranges::max(body_.size());
    for (std::size_t f = body_.faces().size(); f < body_.n_meshed_faces(); ++f) {
      const Facet& facet = body_.facets_[f];
      for (const auto* sides : {&facet.rim, &facet.lines}) {
        if (!*sides) continue;
        for (const plane::Side& side : (*sides)->sides()) {
          const plane::Point middle = plane::between(side.from, side.to, 0.5);
          for (const double across : {-off, off}) {
            const plane::Point own{middle[0] - across * side.along[1], middle[1] + across * side.along[0]};
            if (!facet.holds(own)) continue;
            for (const double above : {-off, off}) {
              const Point p = facet.own_origin + own[0] * facet.along[0] + own[1] * facet.along[1] +
                              (above + dot(facet.normal, facet.origin - facet.own_origin)) * facet.normal;
              if (body_.material_at(p) != body_.material_at(reflection_(p))) return false;
            }
          }
        }
      }
    }
    return true;
  }

  const Body& body_;
  const std::function<Point(const Point&)>& reflection_;
  double near_;                                             ///< [m]
  std::vector<std::pair<double, std::int32_t>> by_height_;  ///< corners
  std::map<Ends, std::int32_t> edges_;
  std::vector<std::int32_t> corner_, edge_;  ///< the image of each one
  std::vector<FaceId> face_;
};

std::vector<Symmetry> Body::symmetries() const {
  std::array<std::vector<double>, 3> planes;
  for (const Facet& facet : facets_)
    if (facet.axis >= 0) planes[index(facet.axis)].push_back(facet.origin[index(facet.axis)]);
  for (auto& positions : planes) {
    std::ranges::sort(positions);
    positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
  }
  std::vector<Symmetry> result;
  for (unsigned axes = 0; axes < 8; ++axes) {
    const Reflection reflection{axes, bounds(), planes, tolerance_};
    const std::function<Point(const Point&)> map = reflection;
    auto starts = Image(*this, map).crack_starts();
    if (!starts) continue;
    const bool is_reflection = axes == 1 || axes == 2 || axes == 4 || axes == 7;
    result.push_back(
        {static_cast<std::uint8_t>(axes), reflection.name(), is_reflection, map, map, std::move(*starts)});
  }
  return result;
}

}  // namespace crackle::geometry
