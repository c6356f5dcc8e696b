// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/crack_surface.h"

#include "common/disjoint_sets.h"
#include "common/failure.h"
#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "geometry/pre_crack.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <unordered_map>

namespace crackle::cracks {

namespace {

using geometry::Point;
using geometry::Realization;
using geometry::Tetrahedron;

/// The two groups of local nodes separated by a cut; the first `n_first` of `node` are one group.
struct Cut {
  std::array<int, 4> node;
  int n_first;
};

constexpr std::array<Cut, fracture::n_cuts> cuts{{{{0, 1, 2, 3}, 1},
                                                  {{1, 0, 2, 3}, 1},
                                                  {{2, 0, 1, 3}, 1},
                                                  {{3, 0, 1, 2}, 1},
                                                  {{0, 1, 2, 3}, 2},
                                                  {{0, 2, 1, 3}, 2},
                                                  {{0, 3, 1, 2}, 2}}};

/// The dual facet between local nodes a and b.
CrackFacet dual_facet(const Realization& realization, const Tetrahedron& tetrahedron, int a, int b) {
  std::array<Point, 4> p;
  for (std::size_t k = 0; k < 4; ++k) p[k] = realization.nodes[index(tetrahedron[k])];
  std::array<std::size_t, 2> other{};
  std::size_t n_other = 0;
  for (int k = 0; k < 4; ++k) {
    if (k != a && k != b) other[n_other++] = static_cast<std::size_t>(k);
  }
  const Point& pa = p[index(a)];
  const Point& pb = p[index(b)];
  CrackFacet facet{};
  facet.corner = {(pa + pb) / 2, (pa + pb + p[other[0]]) / 3, (p[0] + p[1] + p[2] + p[3]) / 4,
                  (pa + pb + p[other[1]]) / 3};
  facet.area = norm(cross(facet.corner[2] - facet.corner[0], facet.corner[3] - facet.corner[1])) / 2;
  return facet;
}

/// For every node, the crack start of a crack through it, or -1.
std::vector<std::int32_t> start_of_nodes(const geometry::Body& body, const Realization& realization) {
  std::vector<std::int32_t> start_of(realization.nodes.size(), -1);
  const auto& starts = body.crack_starts();
  for (const auto& triangle : realization.boundary)
    for (std::size_t start = 0; start < starts.size(); ++start)
      for (const std::int32_t node : triangle.nodes)
        if (starts[start].claims(triangle.surface, realization.nodes[index(node)]))
          start_of[index(node)] = static_cast<std::int32_t>(start);
  return start_of;
}

/// Calls visit(number) for the six edges of a tetrahedron.
template <class Visit>
void for_edges(const Tetrahedron& nodes, const Visit& visit) {
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b) {
      const auto [low, high] = std::minmax({nodes[a], nodes[b]});
      visit((static_cast<std::uint64_t>(low) << 32) |
            static_cast<std::uint64_t>(static_cast<std::uint32_t>(high)));
    }
}

/// The crack starts of the edges of tetrahedra that pre-cracks open, the first of several.
std::unordered_map<std::uint64_t, std::int32_t> start_of_edges(const geometry::Body& body,
                                                               const Realization& realization) {
  const auto& starts = body.crack_starts();
  const auto first = std::ranges::find_if(starts, &geometry::CrackStart::is_pre_crack) - starts.begin();
  const auto n_cracks = std::ranges::count_if(starts, &geometry::CrackStart::is_pre_crack);
  std::unordered_map<std::uint64_t, std::int32_t> start_of;
  for (std::size_t t = 0; t < realization.pre_crack.size(); ++t) {
    if (realization.pre_crack[t] == 0) continue;
    // Random flaws come after the others, and have one start.
    const std::int64_t crack = geometry::PreCrackCut::from(realization.pre_crack[t]).crack;
    const auto start = static_cast<std::int32_t>(first + std::min(crack, n_cracks - 1));
    for_edges(realization.tetrahedra[t], [&](std::uint64_t edge) {
      const auto [entry, is_new] = start_of.try_emplace(edge, start);
      if (!is_new) entry->second = std::min(entry->second, start);
    });
  }
  return start_of;
}

/// Broken tetrahedra joined to cracks, in order of breaking. A crack is identified by its first break.
class CrackForest {
public:
  explicit CrackForest(std::size_t n_breaks) : cracks_(n_breaks), start_(n_breaks, -1) {}

  std::size_t crack_of(std::size_t i) { return cracks_.smallest(i); }
  std::int32_t start_of(std::size_t i) { return start_[crack_of(i)]; }

  /// Adds break i, which touches the earlier breaks `touched` and, unless -1, a crack start.
  void add(std::size_t i, const std::vector<std::size_t>& touched, std::int32_t own_start) {
    // If several cracks meet, the latest touched break that belongs to a crack start decides.
    std::size_t latest = i;
    for (const std::size_t j : touched) {
      if (start_of(j) >= 0 && (latest == i || j > latest)) latest = j;
    }
    const std::int32_t start = latest == i ? own_start : start_of(latest);
    start_[i] = start;
    for (const std::size_t j : touched) {
      if (start_of(j) != -1 && start_of(j) != start) continue;
      cracks_.join(i, j);
      start_[crack_of(i)] = start;
    }
  }

private:
  DisjointSets cracks_;
  std::vector<std::int32_t> start_;  ///< valid at a crack's first break
};

/// The holes into which cracks of other starts ran.
class HoleEntries {
public:
  struct Entry {
    std::int32_t hole;
    std::optional<std::size_t> entering;  ///< break of the other crack
  };

  explicit HoleEntries(const geometry::Body& body) : starts_(body.crack_starts()), into_(starts_.size()) {
    std::iota(into_.begin(), into_.end(), 0);
  }

  /// The start whose crack those of this start continue; itself for most.
  std::int32_t start_of(std::int32_t start) const {
    while (into_[index(start)] != start) start = into_[index(start)];
    return start;
  }

  /// Notes that break i, of a crack of one start, touches another start or its break j.
  void meet(std::int32_t one, std::size_t i, std::int32_t other, std::optional<std::size_t> j) {
    const std::int32_t running = start_of(one), met = start_of(other);
    if (running == met) return;
    if (starts_[index(met)].is_hole) {
      into_[index(met)] = running;
      entries_.push_back({met, i});
    } else if (starts_[index(running)].is_hole) {
      into_[index(running)] = met;
      entries_.push_back({running, j});
    }
  }

  const std::vector<Entry>& entries() const { return entries_; }  ///< in order of breaking

private:
  const std::vector<geometry::CrackStart>& starts_;
  std::vector<std::int32_t> into_;
  std::vector<Entry> entries_;
};

CrackForest connect(const geometry::Body& body, const Realization& realization,
                    std::span<const fracture::Break> breaks, HoleEntries& holes) {
  const std::vector<std::int32_t> start_of_node = start_of_nodes(body, realization);
  CrackForest forest(breaks.size());
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> breaks_at_edge;
  const auto start_of_edge = start_of_edges(body, realization);
  std::vector<std::size_t> touched;
  std::vector<std::int32_t> starts;  // that a break touches
  for (std::size_t i = 0; i < breaks.size(); ++i) {
    const Tetrahedron& nodes = realization.tetrahedra[index(breaks[i].tetrahedron)];
    starts.clear();
    touched.clear();
    for_edges(nodes, [&](std::uint64_t edge) {
      auto& at_edge = breaks_at_edge[edge];
      touched.insert(touched.end(), at_edge.begin(), at_edge.end());
      at_edge.push_back(i);
      if (const auto start = start_of_edge.find(edge); start != start_of_edge.end())
        starts.push_back(start->second);
    });
    const bool is_at_pre_crack = !starts.empty();
    for (const std::int32_t node : nodes)
      if (const std::int32_t start = start_of_node[index(node)]; start >= 0 && !is_at_pre_crack)
        starts.push_back(start);
    forest.add(i, touched, starts.empty() ? -1 : std::ranges::min(starts));
    const std::int32_t start = forest.start_of(i);
    if (start < 0) continue;
    for (const std::int32_t at : starts) holes.meet(start, i, at, {});
    for (const std::size_t j : touched)
      if (const std::int32_t other = forest.start_of(j); other >= 0) holes.meet(start, i, other, j);
  }
  return forest;
}

}  // namespace

double local_spacing(const CrackFacet& facet) {
  return 3 * norm(facet.corner[3] - facet.corner[1]);
}

double CrackSurface::area() const {
  double sum = 0;
  for (const CrackFacet& facet : facets) sum += facet.area;
  return sum;
}

double CrackSurface::area_before_phase() const {
  double sum = 0;
  for (const CrackFacet& facet : facets)
    if (facet.time <= 0) sum += facet.area;
  return sum;
}

double start_of_times(std::span<const fracture::Break> breaks, double phase_start) {
  if (!std::isnan(phase_start) || breaks.empty()) return phase_start;
  return breaks.back().load_time + breaks.back().phase_time;
}

CrackSurface make_crack_surface(const geometry::Body& body, const Realization& realization,
                                std::span<const fracture::Break> breaks, double phase_start) {
  for (const fracture::Break& broken : breaks) {
    if (broken.tetrahedron < 0 ||
        broken.tetrahedron >= static_cast<std::int64_t>(realization.tetrahedra.size()) || broken.cut < 0 ||
        broken.cut >= fracture::n_cuts) {
      fail<std::invalid_argument>(
          "break of tetrahedron {} by cut {}: the realization has {} "
          "tetrahedra and the cuts are 0 to {}",
          broken.tetrahedron, broken.cut, realization.tetrahedra.size(), fracture::n_cuts - 1);
    }
  }
  HoleEntries holes(body);
  CrackForest forest = connect(body, realization, breaks, holes);
  const double start_time = start_of_times(breaks, phase_start);

  const auto& starts = body.crack_starts();
  const auto free_surface = std::ranges::find_if(starts, &geometry::CrackStart::is_free_surface);
  const auto elsewhere =
      free_surface == starts.end() ? -1 : static_cast<std::int32_t>(free_surface - starts.begin());

  CrackSurface surface;
  std::vector<std::int32_t> id(breaks.size(), -1);
  for (std::size_t i = 0; i < breaks.size(); ++i) {
    const fracture::Break& broken = breaks[i];
    // Load times are large compared with phase times: subtracting them first preserves the digits of the
    // phase time.
    const double time = (broken.load_time - start_time) + broken.phase_time;
    const std::size_t first = forest.crack_of(i);
    if (first == i) {
      id[i] = static_cast<std::int32_t>(surface.cracks.size());
      const std::int32_t origin = forest.start_of(i);
      const std::int32_t start = origin >= 0 ? holes.start_of(origin) : elsewhere;
      surface.cracks.push_back({start, 0, time, time, start != origin && origin >= 0 ? origin : -1});
    }
    id[i] = id[first];
    Crack& crack = surface.cracks[index(id[i])];
    crack.last_time = std::max(crack.last_time, time);
    const Cut& cut = cuts[index(broken.cut)];
    for (int a = 0; a < cut.n_first; ++a) {
      for (int b = cut.n_first; b < 4; ++b) {
        CrackFacet facet = dual_facet(realization, realization.tetrahedra[index(broken.tetrahedron)],
                                      cut.node[index(a)], cut.node[index(b)]);
        facet.time = time;
        facet.tetrahedron = broken.tetrahedron;
        facet.crack = id[i];
        crack.area += facet.area;
        surface.facets.push_back(facet);
      }
    }
  }
  for (const auto& [hole, entering] : holes.entries())
    surface.entries.push_back({hole, holes.start_of(hole), entering ? id[forest.crack_of(*entering)] : -1});
  return surface;
}

mechanics::TetrahedronField<double> rayleigh_speeds(const CrackSurface& surface,
                                                    const Realization& realization,
                                                    const mechanics::MaterialField& material) {
  const auto& [elasticity, density] = material;
  if (elasticity.is_uniform() && density.is_uniform())
    return mechanics::rayleigh_speed(elasticity[0], density[0]);
  std::vector<double> speeds(realization.tetrahedra.size(), 0.0);
  for (const CrackFacet& facet : surface.facets) {
    const auto t = static_cast<std::int32_t>(facet.tetrahedron);
    if (speeds[index(t)] == 0) speeds[index(t)] = mechanics::rayleigh_speed(elasticity[t], density[t]);
  }
  return mechanics::TetrahedronField<double>(std::move(speeds));
}

double mean_slowness(const CrackSurface& surface, std::span<const std::size_t> facets,
                     const mechanics::TetrahedronField<double>& rayleigh_speed) {
  if (rayleigh_speed.is_uniform()) return 1 / rayleigh_speed[0];
  double sum = 0, area = 0;
  for (const std::size_t i : facets) {
    const CrackFacet& facet = surface.facets[i];
    sum += facet.area / rayleigh_speed[static_cast<std::int32_t>(facet.tetrahedron)];
    area += facet.area;
  }
  return area > 0 ? sum / area : not_a_number;
}

}  // namespace crackle::cracks
