// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/scaling.h"

#include "common/stopwatch.h"
#include "geometry/partition.h"
#include "geometry/subdomain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace crackle::ensemble {

namespace {

// From plates of 290,000 to 1.8 million tetrahedra.
constexpr double of_node = 6.263, of_triangle = -1.61;
/// Tetrahedra computed twice or more, over (tetrahedra of a part)^(2/3); from the table of
/// tests/benchmark/README.md.
constexpr double of_surface = 9;
/// Smaller parts consist of surface.
constexpr double least_known_part = 2000;
constexpr std::array divisions{2, 8, 64, 512};

constexpr std::array figures{&LargestPart::tetrahedra, &LargestPart::ghosts, &LargestPart::neighbours,
                             &LargestPart::seconds};
/// Powers of the number of parts, of compact parts.
constexpr std::array compact_powers{-2.0 / 3, -2.0 / 3, 0.0, 0.0};

}  // namespace

double expected_tetrahedra(double n_nodes, double n_triangles) {
  return of_node * n_nodes + of_triangle * n_triangles;
}

double compact_part(double n_tetrahedra, double n_parts) {
  if (n_parts <= 1) return n_tetrahedra;
  const double share = n_tetrahedra / n_parts;
  return std::min(n_tetrahedra, share + of_surface * std::pow(share, 2.0 / 3));
}

LargestPart largest_part(const geometry::Realization& realization, int n_parts, double halo) {
  LargestPart largest;
  const ThreadClock clock;
  const auto parts = geometry::split(realization, geometry::partition(realization, n_parts), halo);
  largest.seconds = clock.seconds();
  for (const geometry::Subdomain& part : parts) {
    std::set<std::int32_t> neighbours;
    for (const auto& ghost : part.layout.ghosts) neighbours.insert(ghost.rank);
    largest.tetrahedra = std::max<double>(largest.tetrahedra, part.n_tetrahedra());
    largest.ghosts = std::max<double>(largest.ghosts, part.n_local() - part.layout.n_owned);
    largest.neighbours = std::max(largest.neighbours, static_cast<double>(neighbours.size()));
  }
  return largest;
}

PartSizes::PartSizes(const geometry::Realization& realization, double halo, int most_parts, double ratio)
    : n_tetrahedra_(ratio * static_cast<double>(realization.tetrahedra.size())) {
  const auto n = static_cast<double>(realization.tetrahedra.size());
  // Layers at surfaces are a tetrahedron thick, a halo is not.
  const double of_layers = halo > 0 ? ratio : std::pow(ratio, 2.0 / 3);
  for (const int n_parts : divisions) {
    const int last = known_.empty() ? 1 : static_cast<int>(known_.back().n_parts);
    if (last >= most_parts || n_parts > n || (last > 1 && n / n_parts < least_known_part)) break;
    LargestPart part = largest_part(realization, n_parts, halo);
    part.tetrahedra = of_layers * std::max(1.0, part.tetrahedra - n / n_parts);
    part.ghosts *= of_layers;
    part.seconds *= ratio;
    known_.push_back({static_cast<double>(n_parts), part});
  }
}

LargestPart PartSizes::of(int n_parts) const {
  if (n_parts <= 1 || known_.empty()) return {.tetrahedra = n_tetrahedra_};
  const double asked = n_parts;
  LargestPart part;
  const auto next = std::ranges::find_if(known_, [&](const Known& one) { return one.n_parts >= asked; });
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const auto figure = figures[i];
    const auto [n, largest] = next == known_.end() ? known_.back() : *next;
    double power = compact_powers[i];
    if (next != known_.end() && next != known_.begin() && largest.*figure > 0) {
      const auto& [n_before, before] = *std::prev(next);
      if (before.*figure > 0) power = std::log(largest.*figure / (before.*figure)) / std::log(n / n_before);
    }
    part.*figure = largest.*figure * std::pow(asked / n, power);
  }
  part.tetrahedra = std::min(n_tetrahedra_, n_tetrahedra_ / asked + part.tetrahedra);
  return part;
}

double GroupTraffic::seconds(int n_ranks, const LargestPart& part, const Network& network) const {
  if (n_ranks <= 1) return 0;
  const double exchange =
      part.neighbours * network.latency + bytes_per_ghost * part.ghosts / network.bandwidth;
  return exchanges * exchange + agreements * std::ceil(std::log2(n_ranks)) * network.latency;
}

}  // namespace crackle::ensemble
