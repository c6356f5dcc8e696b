// SPDX-License-Identifier: GPL-3.0-or-later
#include "loaded_region.h"

#include "common/index.h"
#include "common/vector.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace crackle::mechanics {

namespace {

/// A part of a segment or triangle.
template <std::size_t n>
struct Part {
  std::array<std::array<double, n>, n> shape;  ///< the shape functions at each of its corners
  std::array<double, n> coordinate;            ///< of its corners, along the factor's axis
  double measure;
};

/// Cuts a part in two where one of its edges crosses a coordinate. @return false if none does
template <std::size_t n>
bool cut(const Part<n>& part, double at, Part<n>& below, Part<n>& above) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      if (!(part.coordinate[i] < at && at < part.coordinate[j])) continue;
      const double share = (at - part.coordinate[i]) / (part.coordinate[j] - part.coordinate[i]);
      below = above = part;
      for (std::size_t a = 0; a < n; ++a)
        below.shape[j][a] = above.shape[i][a] =
            part.shape[i][a] + share * (part.shape[j][a] - part.shape[i][a]);
      below.coordinate[j] = above.coordinate[i] = at;
      below.measure = share * part.measure;
      above.measure = (1 - share) * part.measure;
      return true;
    }
  return false;
}

/// @param kink first entry of the factor's table that may lie inside the part
template <std::size_t n>
void add(const input::Profile& factor, const Part<n>& part, std::size_t kink, std::array<double, n>& sum) {
  for (; kink < factor.table.size(); ++kink) {
    Part<n> below, above;
    if (!cut(part, factor.table[kink].first, below, above)) continue;
    add(factor, below, kink, sum);
    add(factor, above, kink, sum);
    return;
  }
  // The integral of the product of two linear functions, from their values at the corners.
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const double weight = part.measure * (i == j ? 2 : 1) / static_cast<double>(n * (n + 1));
      for (std::size_t a = 0; a < n; ++a) sum[a] += weight * factor.at(part.coordinate[i]) * part.shape[j][a];
    }
}

/// Integrals of a factor times each linear shape function over a segment (two corners) or a triangle (three).
/// Exact, as both are cut where the factor has a kink.
/// @param measure its length [m] or area [m^2]
template <std::size_t n>
std::array<double, n> factor_shares(const input::Profile& factor, const std::array<Vector, n>& corners,
                                    double measure) {
  Part<n> whole{};
  whole.measure = measure;
  for (std::size_t i = 0; i < n; ++i) {
    whole.shape[i][i] = 1;
    whole.coordinate[i] = corners[i][factor.axis];
  }
  std::array<double, n> sum{};
  add(factor, whole, 0, sum);
  return sum;
}

struct TriangleGeometry {
  geometry::Point centroid;
  double area;
};

TriangleGeometry measure(const geometry::Subdomain& subdomain, const geometry::Triangle& nodes) {
  const auto& a = subdomain.nodes[index(nodes[0])];
  const auto& b = subdomain.nodes[index(nodes[1])];
  const auto& c = subdomain.nodes[index(nodes[2])];
  return {(a + b + c) / 3, norm(cross(b - a, c - a)) / 2};
}

template <std::size_t n>
std::array<double, n> shares_of(const geometry::Subdomain& subdomain,
                                const std::array<std::int32_t, n>& nodes, double measure,
                                const std::optional<input::Profile>& factor) {
  std::array<double, n> shares;
  shares.fill(measure / static_cast<double>(n));
  if (!factor) return shares;
  std::array<Vector, n> corners;
  std::ranges::transform(nodes, corners.begin(),
                         [&](std::int32_t node) { return subdomain.nodes[index(node)]; });
  return factor_shares(*factor, corners, measure);
}

/// Totals from the nodes, which share what a factor makes of the region. Collective.
void sum_over_nodes(const parallel::Communicator& group, LoadedRegion& region) {
  region.resultant = parallel::exact_sum(group, region.area);
  std::vector<double> magnitudes = region.area;
  for (double& area : magnitudes) area = std::abs(area);
  region.total_area = parallel::exact_sum(group, magnitudes);
}

/// A triangle is counted by the rank that owns its lowest node.
bool counts(const geometry::Subdomain& subdomain, const geometry::Triangle& nodes) {
  const auto lowest = *std::ranges::min_element(
      nodes, {}, [&](std::int32_t node) { return subdomain.layout.number[index(node)]; });
  return lowest < subdomain.layout.n_owned;
}

/// The mesh edges that form a line region, as pairs of node numbers in the realization: each once, though
/// shared by triangles, in the same order on every rank.
using LineEdges = std::map<std::pair<std::int64_t, std::int64_t>, std::array<std::int32_t, 2>>;

LineEdges line_edges(const geometry::ConditionRegion& region, const geometry::Subdomain& subdomain) {
  LineEdges edges;
  for (const auto& triangle : subdomain.boundary) {
    const geometry::FacePart* part = region.on(triangle.surface);
    if (part == nullptr) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      std::array<std::int32_t, 2> ends{triangle.nodes[i], triangle.nodes[(i + 1) % 3]};
      const auto number = [&](std::int32_t node) { return subdomain.layout.number[index(node)]; };
      if (number(ends[0]) > number(ends[1])) std::swap(ends[0], ends[1]);
      if (std::ranges::all_of(ends, [&](auto node) { return part->contains(subdomain.nodes[index(node)]); }))
        edges.emplace(std::pair{number(ends[0]), number(ends[1])}, ends);
    }
  }
  return edges;
}

/// A line region, with lengths instead of areas, or a point region, with the number of points. Collective.
LoadedRegion loaded_line(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                         const geometry::Subdomain& subdomain, const std::optional<input::Profile>& factor) {
  std::map<std::int32_t, double> tributary;
  std::vector<double> counted;
  if (region.n_dimensions == 1) {
    for (const auto& [numbers, ends] : line_edges(region, subdomain)) {
      const double length = norm(subdomain.nodes[index(ends[1])] - subdomain.nodes[index(ends[0])]);
      if (ends[0] < subdomain.layout.n_owned) counted.push_back(length);
      const auto shares = shares_of(subdomain, ends, length, factor);
      for (std::size_t i = 0; i < 2; ++i)
        if (ends[i] < subdomain.layout.n_owned) tributary[ends[i]] += shares[i];
    }
  } else {
    for (const auto node : nodes_in_region(region, subdomain)) {
      counted.push_back(1);
      tributary[node] = factor ? factor->at(subdomain.nodes[index(node)]) : 1;
    }
  }
  LoadedRegion line;
  line.resultant = line.total_area = parallel::exact_sum(group, counted);
  for (const auto& [node, length] : tributary) {
    line.nodes.push_back(node);
    line.area.push_back(length);
  }
  if (factor) sum_over_nodes(group, line);
  return line;
}

}  // namespace

std::vector<std::int32_t> nodes_in_region(const geometry::ConditionRegion& region,
                                          const geometry::Subdomain& subdomain) {
  std::set<std::int32_t> nodes;
  for (const auto& triangle : subdomain.boundary) {
    const geometry::FacePart* part = region.on(triangle.surface);
    if (part == nullptr) continue;
    for (const auto node : triangle.nodes)
      if (node < subdomain.layout.n_owned && part->contains(subdomain.nodes[index(node)])) nodes.insert(node);
  }
  return {nodes.begin(), nodes.end()};
}

LoadedRegion loaded_faces(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                          const geometry::Subdomain& subdomain,
                          const std::function<double(const geometry::BoundaryTriangle&)>& share,
                          const std::optional<input::Profile>& factor) {
  std::map<std::int32_t, double> tributary;
  std::vector<double> counted_areas;
  for (const auto& triangle : subdomain.boundary) {
    const geometry::FacePart* here = region.on(triangle.surface);
    if (here == nullptr) continue;
    const auto [centroid, area] = measure(subdomain, triangle.nodes);
    if (!here->contains(centroid)) continue;
    const double part = share(triangle);
    if (part == 0) continue;
    if (counts(subdomain, triangle.nodes)) counted_areas.push_back(part * area);
    const auto shares = shares_of(subdomain, triangle.nodes, area, factor);
    for (std::size_t i = 0; i < 3; ++i)
      if (triangle.nodes[i] < subdomain.layout.n_owned) tributary[triangle.nodes[i]] += part * shares[i];
  }
  LoadedRegion face;
  face.resultant = parallel::exact_sum(group, counted_areas);
  for (double& area : counted_areas) area = std::abs(area);
  face.total_area = parallel::exact_sum(group, counted_areas);
  for (const auto& [node, area] : tributary) {
    face.nodes.push_back(node);
    face.area.push_back(area);
  }
  if (factor) sum_over_nodes(group, face);
  return face;
}

LoadedRegion loaded_region(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                           const geometry::Subdomain& subdomain,
                           const std::optional<input::Profile>& factor) {
  if (region.n_dimensions < 2) return loaded_line(group, region, subdomain, factor);
  return loaded_faces(
      group, region, subdomain, [](const geometry::BoundaryTriangle&) { return 1.0; }, factor);
}

}  // namespace crackle::mechanics
