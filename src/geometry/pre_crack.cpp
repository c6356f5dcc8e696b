// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/pre_crack.h"

#include "geometry/body.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace crackle::geometry {

namespace {

/// Chords of an ellipse's border, for drawing and refinement.
constexpr int n_chords = 48;

Vector unit(const Vector& v) {
  return v / norm(v);
}

/// Twice the vector area of a polygon.
Vector vector_area(const std::vector<Vector>& corners) {
  Vector sum{};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum = sum + cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return sum;
}

/// The number of the cut that parts the corners above a plane from the others, by the bits of those above.
int cut_of(unsigned above) {
  if (std::popcount(above) == 2) return 3 + std::countr_zero((above & 1u) != 0 ? above & ~1u : ~above & 14u);
  return std::countr_zero(std::popcount(above) == 1 ? above : ~above & 15u);
}

}  // namespace

std::array<Vector, 2> across(const Vector& direction) {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (std::abs(direction[i]) < std::abs(direction[axis])) axis = i;
  Vector along{};
  along[axis] = 1;
  const Vector first = unit(along - dot(along, direction) * direction);
  return {first, cross(direction, first)};
}

PreCrackFigure::PreCrackFigure(const plane::PreCrack& crack, const Box& bounds) {
  std::vector<Point> corners = crack.polygon;
  if (crack.line) {
    const auto& [from, to] = *crack.line;
    const double lower = bounds.lower[0], upper = bounds.upper[0];
    corners = {
        {lower, from[0], from[1]}, {lower, to[0], to[1]}, {upper, to[0], to[1]}, {upper, from[0], from[1]}};
  }
  if (!corners.empty()) {
    const Vector normal = unit(vector_area(corners)), along = unit(corners[1] - corners[0]);
    patch_ = {{}, corners[0], {along, cross(normal, along), normal}};
    border_ = corners;
  } else {
    const Vector normal = unit(crack.normal);
    const auto [first, second] = across(normal);
    patch_ = {{}, crack.center, {first, second, normal}};
    semi_axes_ = crack.semi_axes;
    const auto [a, b] = semi_axes_;
    for (int i = 0; i < n_chords; ++i) {
      const double angle = 2 * std::numbers::pi * i / n_chords;
      border_.push_back(patch_.at({a * std::cos(angle), b * std::sin(angle), 0}));
    }
  }
  patch_.domain = {{}, {}};
  for (const Point& p : border_) {
    const Point own = patch_.own(p);
    own_border_.push_back({own[0], own[1]});
    patch_.domain.include({own[0], own[1], 0});
  }
}

bool PreCrackFigure::holds(const Point& p) const {
  const Point own = patch_.own(p);
  if (semi_axes_[0] > 0) {
    const double u = own[0] / semi_axes_[0], v = own[1] / semi_axes_[1];
    return u * u + v * v <= 1;
  }
  return plane::holds(own_border_, {own[0], own[1]});
}

int PreCrackFigure::cut(const std::array<Point, 4>& corners) const {
  std::array<double, 4> heights{};
  unsigned above = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    heights[i] = height(corners[i]);
    if (heights[i] >= 0) above |= 1u << i;
  }
  if (above == 0 || above == 15) return -1;
  Point middle{};
  double n = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k)
      if (heights[i] >= 0 && heights[k] < 0) {
        const double share = heights[i] / (heights[i] - heights[k]);
        middle = middle + corners[i] + share * (corners[k] - corners[i]);
        n += 1;
      }
  return holds(middle / n) ? cut_of(above) : -1;
}

std::vector<std::int32_t> pre_crack_cuts(const Realization& realization,
                                         std::span<const plane::PreCrack> cracks, const Box& bounds) {
  std::vector<std::int32_t> cuts(cracks.empty() ? 0 : realization.tetrahedra.size(), 0);
  std::vector<std::uint8_t> is_above(realization.nodes.size());
  for (std::size_t number = 0; number < cracks.size(); ++number) {
    const PreCrackFigure figure(cracks[number], bounds);
    std::ranges::transform(realization.nodes, is_above.begin(),
                           [&](const Point& p) { return static_cast<std::uint8_t>(figure.height(p) >= 0); });
    for (std::size_t t = 0; t < cuts.size(); ++t) {
      const Tetrahedron& nodes = realization.tetrahedra[t];
      const int n_above = is_above[index(nodes[0])] + is_above[index(nodes[1])] + is_above[index(nodes[2])] +
                          is_above[index(nodes[3])];
      if (n_above == 0 || n_above == 4 || cuts[t] != 0) continue;
      std::array<Point, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) corners[i] = realization.nodes[index(nodes[i])];
      if (const int cut = figure.cut(corners); cut >= 0)
        cuts[t] = PreCrackCut{static_cast<std::int32_t>(number), cut}.code();
    }
  }
  return cuts;
}

void open_pre_cracks(std::span<const plane::PreCrack> cracks, const Box& bounds, Realization& realization) {
  realization.pre_crack = pre_crack_cuts(realization, cracks, bounds);
  realization.pre_crack_normal.clear();
  for (const plane::PreCrack& crack : cracks)
    realization.pre_crack_normal.push_back(PreCrackFigure(crack, bounds).normal());
}

namespace {

std::vector<CrackStart> starts_of(std::span<const plane::PreCrack> cracks, bool has_flaws,
                                  const Box& bounds) {
  std::vector<CrackStart> starts;
  for (const plane::PreCrack& crack : cracks) {
    const PreCrackFigure figure(crack, bounds);
    CrackStart& start = starts.emplace_back();
    start.name = fmt::format("crack-{}", starts.size() - 1);
    start.plane = figure.patch();
    start.border = figure.border();
    for (const Point& p : start.border) start.tip = start.tip + p / static_cast<double>(start.border.size());
  }
  if (has_flaws) {
    CrackStart& start = starts.emplace_back();
    start.name = "flaws";
    start.tip = bounds.lower + (bounds.upper - bounds.lower) / 2;
  }
  for (CrackStart& start : starts) {
    start.is_straight = false;
    start.is_pre_crack = true;
  }
  return starts;
}

/// mesh.notch_spacing along the fronts.
SpacingRule spacing_of(std::span<const plane::PreCrack> cracks, const Box& bounds) {
  std::vector<Box> boxes;
  std::vector<std::string> reasons;
  for (std::size_t number = 0; number < cracks.size(); ++number) {
    const std::vector<Point> border = PreCrackFigure(cracks[number], bounds).border();
    const bool is_line = cracks[number].line.has_value();
    // Of a crack through the thickness the two lines along it are its front, and sides 0 and 2 lie on faces.
    for (std::size_t i = 0; i < border.size(); ++i) {
      if (is_line && i % 2 == 0) continue;
      Box box{border[i], border[i]};
      box.include(border[(i + 1) % border.size()]);
      boxes.push_back(box);
      reasons.push_back(fmt::format("notch_spacing at crack-{}", number));
    }
  }
  return [boxes, reasons](const Body& body, const input::Mesh& mesh, std::vector<SpacingSource>& sources) {
    if (mesh.notch_spacing >= mesh.spacing) return;
    for (std::size_t i = 0; i < boxes.size(); ++i)
      if (distance(boxes[i], body.bounds()) == 0)
        sources.push_back({boxes[i], mesh.notch_spacing, mesh.growth, reasons[i]});
  };
}

}  // namespace

void add_pre_cracks(Complex& complex, const input::Model& model) {
  const std::vector<plane::PreCrack>& cracks = model.specimen.cracks;
  auto& starts = complex.crack_starts;
  const bool has_free_surface = !starts.empty() && starts.back().is_free_surface;
  const auto added = starts_of(cracks, !model.flaws.empty(), complex.bounds);
  starts.insert(starts.end() - (has_free_surface ? 1 : 0), added.begin(), added.end());
  if (!cracks.empty()) complex.spacing_rules.push_back(spacing_of(cracks, complex.bounds));
}

}  // namespace crackle::geometry
