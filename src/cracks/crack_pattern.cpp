// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/crack_pattern.h"

#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "cracks/crack_ligaments.h"

#include "crack_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace crackle::cracks {

namespace {

constexpr int n_stations = 50;  // of crossed_shares and path_overlap

using geometry::CrackStart;

/// Advance of a crack along its ligament.
struct Advance {
  double share = 0;        ///< of the ligament, up to the farthest station with a crossing
  double time = infinity;  ///< when it first opened there [s]
};

geometry::CrossPlane station(const CrackStart& start, int i) {
  return start.plane_at(start.ligament * (i + 0.5) / n_stations);
}

Advance advance(const geometry::Body& body, const CrackSurface& surface, const CrackLigament& ligament) {
  for (int i = n_stations - 1; i >= 0 && !ligament.facets.empty(); --i) {
    const std::vector<Trace> traces = intersect(surface, ligament.facets, station(ligament.line, i));
    if (const auto crossing = main_crossing(traces, Projection(body).thickness()))
      return {(i + 1.0) / n_stations, crossing->time};
  }
  return {};
}

/// For each crack start, the ligament on which its crack advanced farthest; among equals the one where it
/// arrived first.
std::vector<Advance> advances_of_starts(const geometry::Body& body, const CrackSurface& surface) {
  std::vector<Advance> farthest(body.crack_starts().size());
  for (const CrackLigament& ligament : crack_ligaments(body, surface, Followed::through_holes)) {
    const Advance found = advance(body, surface, ligament);
    Advance& of_start = farthest[index(ligament.start)];
    if (std::pair(-found.share, found.time) < std::pair(-of_start.share, of_start.time)) of_start = found;
  }
  return farthest;
}

/// Share of the body's width covered by crossings of cracks without a crack start.
double share_from_elsewhere(const geometry::Body& body, const CrackSurface& surface) {
  const std::vector<std::size_t> facets = facets_from(surface, -1);
  const Projection projection(body);
  int n_covered = 0;
  for (int i = 0; i < n_stations && !facets.empty(); ++i) {
    const std::vector<Trace> traces = intersect(surface, facets, projection.at_width(i + 0.5, n_stations));
    if (!group(traces, projection.thickness()).empty()) ++n_covered;
  }
  return static_cast<double>(n_covered) / n_stations;
}

/// A crack's offset from its ligament: the main crossing at every station, NaN if there is none.
std::vector<double> offsets_from_ligament(const geometry::Body& body, const CrackSurface& surface,
                                          int number) {
  const CrackStart& start = body.crack_starts()[index(number)];
  const std::vector<std::size_t> facets = facets_from(surface, number);
  std::vector<double> offsets;
  for (int i = 0; i < n_stations; ++i) {
    const std::vector<Trace> traces = intersect(surface, facets, station(start, i));
    const std::optional<Crossing> crossing = main_crossing(traces, Projection(body).thickness());
    offsets.push_back(crossing ? crossing->mean - dot(start.tip, start.across) : not_a_number);
  }
  return offsets;
}

}  // namespace

std::vector<double> crossed_shares(const geometry::Body& body, const CrackSurface& surface) {
  std::vector<double> shares;
  for (const Advance& found : advances_of_starts(body, surface)) shares.push_back(found.share);
  return shares;
}

int leading_start(const geometry::Body& body, const CrackSurface& surface) {
  int leading = -1;
  Advance farthest{started_share};
  const std::vector<Advance> advances = advances_of_starts(body, surface);
  for (std::size_t number = 0; number < advances.size(); ++number) {
    const Advance& found = advances[number];
    if (found.share < farthest.share || (found.share == farthest.share && !(found.time < farthest.time)))
      continue;
    leading = static_cast<int>(number);
    farthest = found;
  }
  return leading;
}

LeadersHole leaders_hole(const geometry::Body& body, const CrackSurface& surface, int leading) {
  const auto entry = std::ranges::find(surface.entries, leading, &HoleEntry::start);
  if (entry == surface.entries.end()) return {};
  LeadersHole found{entry->hole, HolePassage::ends};
  bool is_past = false;  // the crack itself has passed the hole, which it only touched
  const std::vector<CrackLigament> behind = crack_ligaments(body, surface, entry->hole);
  for (const CrackLigament& before : crack_ligaments(body, surface, Followed::through_holes)) {
    if (before.start != leading) continue;
    const Vector towards = body.crack_starts()[index(entry->hole)].tip - before.line.tip;
    for (const CrackLigament& ligament : behind)
      if (dot(ligament.line.along, towards) > 0) found.passage = HolePassage::passes;
    for (const std::size_t i : before.facets) {
      const CrackFacet& facet = surface.facets[i];
      if (surface.cracks[index(facet.crack)].origin() != entry->hole)
        is_past |= dot(facet.corner[2] - before.line.tip, towards) > dot(towards, towards);
    }
  }
  return found.passage == HolePassage::ends && is_past ? LeadersHole{} : found;
}

double path_overlap(const geometry::Body& body, const CrackSurface& surface, int one, int other) {
  const CrackStart& start = body.crack_starts()[index(one)];
  const CrackStart& opposite = body.crack_starts()[index(other)];
  if (!start.is_straight || !opposite.is_straight) return not_a_number;
  constexpr double rounding = 1e-9;  // of the cosine between the ligaments
  if (start.direction * opposite.direction * dot(start.along, opposite.along) > rounding - 1)
    return not_a_number;
  const double distance = overlap_distance_share * Projection(body).width();
  const std::vector<double> path = offsets_from_ligament(body, surface, one);
  const std::vector<double> turned = offsets_from_ligament(body, surface, other);
  const double same_side = dot(start.across, opposite.across);
  int n_reached = 0;
  int n_over = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!std::isnan(path[i]) || !std::isnan(turned[i])) ++n_reached;
    // Rotation changes the sign of the offset from the ligament.
    if (std::abs(path[i] + same_side * turned[i]) <= distance) ++n_over;
  }
  return n_reached > 0 ? static_cast<double>(n_over) / n_reached : not_a_number;
}

double pattern_overlap(const geometry::Body& body, const CrackSurface& surface) {
  const std::vector<double> shares = crossed_shares(body, surface);
  if (shares.size() < 2) return not_a_number;
  std::vector<int> starts(shares.size());
  std::iota(starts.begin(), starts.end(), 0);
  std::stable_sort(starts.begin(), starts.end(),
                   [&](int a, int b) { return shares[index(a)] > shares[index(b)]; });
  return path_overlap(body, surface, starts[0], starts[1]);
}

Pattern classify(const geometry::Body& body, const CrackSurface& surface) {
  if (share_from_elsewhere(body, surface) >= developed_share) return Pattern::other;
  int n_developed = 0;
  double largest = 0;
  for (const CrackLigament& ligament : crack_ligaments(body, surface, Followed::through_holes)) {
    const double share = advance(body, surface, ligament).share;
    largest = std::max(largest, share);
    if (share >= developed_share) ++n_developed;
  }
  if (n_developed == 1 && largest >= through_share) return Pattern::one_crack;
  // A start with a developed crack is one of the two whose cracks run farthest.
  if (n_developed == 2 && !(pattern_overlap(body, surface) < min_overlap)) return Pattern::two_cracks;
  return largest < started_share ? Pattern::none : Pattern::other;
}

}  // namespace crackle::cracks
