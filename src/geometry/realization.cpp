// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/realization.h"

#include "common/failure.h"
#include "common/freed_memory.h"
#include "common/index.h"
#include "geometry/face_neighbours.h"
#include "geometry/symmetry.h"

#include "redraw.h"
#include "redraw_stiffest.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr int max_rounds = 200;

/// The same tetrahedron with its smallest node first and the smallest of the others second.
Tetrahedron canonical(const Tetrahedron& t) {
  // The even permutations that bring each corner to the front; the other three are then rotated.
  constexpr std::array<std::array<std::size_t, 4>, 4> to_front{
      {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}}};
  const auto& order = to_front[index(std::min_element(t.begin(), t.end()) - t.begin())];
  Tetrahedron result{t[order[0]], t[order[1]], t[order[2]], t[order[3]]};
  std::rotate(result.begin() + 1, std::min_element(result.begin() + 1, result.end()), result.end());
  return result;
}

Triangle canonical(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

/// Sorts cells, whose first node is their smallest, by their sorted nodes: first into buckets by first node,
/// which is most of the work, then within the buckets.
void sort_cells(std::vector<Tetrahedron>& cells, std::size_t n_nodes) {
  std::vector<std::size_t> begin(n_nodes + 1, 0);
  for (const Tetrahedron& cell : cells) ++begin[index(cell[0]) + 1];
  for (std::size_t i = 0; i < n_nodes; ++i) begin[i + 1] += begin[i];
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  std::vector<Tetrahedron> sorted(cells.size());
  for (const Tetrahedron& cell : cells) sorted[next[index(cell[0])]++] = cell;
  for (std::size_t i = 0; i < n_nodes; ++i)
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(begin[i]),
              sorted.begin() + static_cast<std::ptrdiff_t>(begin[i + 1]),
              [](const Tetrahedron& a, const Tetrahedron& b) {
                if (a[1] != b[1]) return a[1] < b[1];
                const auto [a2, a3] = std::minmax(a[2], a[3]);
                const auto [b2, b3] = std::minmax(b[2], b[3]);
                return a2 != b2 ? a2 < b2 : a3 < b3;
              });
  cells.swap(sorted);
}

/// The symmetry of body and spacing applied to a sample.
Symmetry chosen_symmetry(const Body& body, const input::Mesh& mesh, std::uint64_t seed,
                         std::uint64_t sample) {
  if (mesh.symmetry == input::MeshSymmetry::none || mesh.perturbation == 0) return symmetry_of(body, 0);
  std::vector<Symmetry> all = symmetries(body, mesh);
  return std::move(all[index(RandomStream(seed, sample, "turn").bits() % all.size())]);
}

/// Maps a tessellation by a symmetry of the body.
void apply(const Symmetry& symmetry, std::vector<Point>& nodes, TessellationContent& content) {
  if (symmetry.code == 0) return;
  for (Point& p : nodes) p = symmetry.image(p);
  if (!symmetry.is_reflection) return;
  for (Tetrahedron& cell : content.tetrahedra) std::swap(cell[2], cell[3]);
  for (Triangle& triangle : content.boundary) std::swap(triangle[1], triangle[2]);
}

/// True for the nodes of tetrahedra of several materials.
std::vector<std::uint8_t> nodes_between(const Realization& realization) {
  std::vector<int> first(realization.nodes.size(), -1);
  std::vector<std::uint8_t> result(realization.nodes.size(), 0);
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i)
    for (const std::int32_t node : realization.tetrahedra[i]) {
      int& known = first[index(node)];
      if (known < 0) known = realization.material[i];
      if (known != realization.material[i]) result[index(node)] = 1;
    }
  return result;
}

/// The pairs of materials that meet in faces at each node.
std::map<std::int32_t, std::set<std::size_t>> pairs_at_nodes(const Realization& realization,
                                                             std::span<const std::array<int, 2>> pairs) {
  const std::vector<std::uint8_t> is_between = nodes_between(realization);
  std::vector<Tetrahedron> near;
  std::vector<int> material;
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i) {
    const Tetrahedron& t = realization.tetrahedra[i];
    if (std::ranges::count_if(t, [&](std::int32_t node) { return is_between[index(node)] != 0; }) < 3)
      continue;
    near.push_back(t);
    material.push_back(realization.material[i]);
  }
  const auto neighbours = face_neighbours(near);
  std::map<std::int32_t, std::set<std::size_t>> result;
  for (std::size_t i = 0; i < near.size(); ++i)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const std::int32_t other = neighbours[i][opposite];
      if (other < 0 || material[index(other)] == material[i]) continue;
      const std::array<int, 2> own{material[i], material[index(other)]};
      for (std::size_t pair = 0; pair < pairs.size(); ++pair)
        for (std::size_t k = 0; k < 4 && std::ranges::is_permutation(pairs[pair], own); ++k)
          if (k != opposite) result[near[i][k]].insert(pair);
    }
  return result;
}

}  // namespace

Realization make_realization(const Body& body, const MotherPoints& base, const input::Mesh& mesh,
                             std::uint64_t seed, std::uint64_t sample, int attempt) {
  const std::string suffix = attempt == 0 ? "" : fmt::format(", attempt {}", attempt);
  const RandomStream stream(seed, sample, "disturbance" + suffix);
  const std::vector<PlaceId> place = body.places_of(base.position);
  const auto draw_from = [&](const RandomStream& purpose, std::size_t i, std::int32_t number,
                             double amplitude) {
    return displaced(body, base.position[i], place[i], amplitude * mesh.perturbation * base.spacing[i],
                     purpose.substream(i).substream(static_cast<std::uint64_t>(number)));
  };
  const auto draw = [&](std::size_t i, std::int32_t number, double amplitude) {
    return draw_from(stream, i, number, amplitude);
  };
  Realization realization;
  realization.nodes.resize(base.size());
  for (std::size_t i = 0; i < base.size(); ++i) realization.nodes[i] = draw(i, 0, 1);

  auto tessellation = std::make_unique<Tessellation>(body, realization.nodes, mesh.min_quality);
  const RedrawOutcome outcome =
      redraw(*tessellation, base.movable,
             [&](std::int32_t node, std::int32_t number, double amplitude) {
               return draw(index(node), number, amplitude);
             },
             RandomStream(seed, sample, "choice of redrawn points" + suffix), {.max_rounds = max_rounds});
  if (!outcome.remaining.empty())
    fail(
        "sample {}: after {} rounds of redrawing, {} tetrahedra are still below min_quality = {} or extend "
        "beyond the body",
        sample, outcome.rounds, outcome.remaining.size(), mesh.min_quality);
  const RandomStream again(seed, sample, "redrawn stiff nodes" + suffix);
  const std::int64_t n_stiff =
      mesh.perturbation == 0
          ? 0
          : redraw_stiffest(*tessellation, base, [&](std::int32_t node, std::int32_t number) {
              return draw_from(again, index(node), number, 1);
            });

  std::ranges::copy(tessellation->points(), realization.nodes.begin());
  TessellationContent content = tessellation->content();
  tessellation.reset();  // takes six times the memory of its content
  release_freed_memory();
  const Symmetry symmetry = chosen_symmetry(body, mesh, seed, sample);
  apply(symmetry, realization.nodes, content);
  realization.report.symmetry = symmetry.code;
  realization.tetrahedra = std::move(content.tetrahedra);
  for (Tetrahedron& cell : realization.tetrahedra) cell = canonical(cell);
  sort_cells(realization.tetrahedra, realization.nodes.size());

  for (Triangle& triangle : content.boundary) triangle = canonical(triangle);
  std::sort(content.boundary.begin(), content.boundary.end());
  realization.boundary.reserve(content.boundary.size());
  const auto node = [&](std::int32_t number) -> const Point& { return realization.nodes[index(number)]; };
  for (const Triangle& t : content.boundary)
    realization.boundary.push_back({t, body.face_of({node(t[0]), node(t[1]), node(t[2])})});

  if (!body.material_volumes().empty())
    for (const Tetrahedron& cell : realization.tetrahedra)
      realization.material.push_back(
          static_cast<std::uint8_t>(body.material_at(centroid(realization.nodes, cell))));
  if (!body.interfaces().empty()) realization.interface = interface_numbers(realization, body.interfaces());

  realization.report.rounds = outcome.rounds;
  realization.report.attempt = attempt;
  realization.report.redrawn_points = outcome.redrawn_points + n_stiff;
  realization.report.min_quality = verify(realization, body, mesh.min_quality);
  return realization;
}

std::vector<std::uint8_t> interface_numbers(const Realization& realization,
                                            std::span<const std::array<int, 2>> pairs) {
  const auto at_nodes = pairs_at_nodes(realization, pairs);
  std::vector<std::uint8_t> result(realization.tetrahedra.size(), 0);
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::size_t first = pairs.size();
    for (const std::int32_t node : realization.tetrahedra[i]) {
      const auto found = at_nodes.find(node);
      if (found == at_nodes.end()) continue;
      for (const std::size_t pair : found->second)
        if (std::ranges::find(pairs[pair], int{realization.material[i]}) != pairs[pair].end())
          first = std::min(first, pair);
    }
    if (first < pairs.size()) result[i] = static_cast<std::uint8_t>(first + 1);
  }
  return result;
}

}  // namespace crackle::geometry
