// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"

#include "crossings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace crackle::analysis {

namespace {

constexpr int n_stations = 50;  // of crossed_shares and path_overlap
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// How far facets reach along an axis: the share of the way from `start` over the signed `length` up to the
/// farthest station with a crossing.
double farthest_share(const CrackSurface& surface, std::span<const std::size_t> facets, int axis, int across,
                      double start, double length, double thickness) {
  for (int i = n_stations - 1; i >= 0 && !facets.empty(); --i) {
    const double position = start + length * (i + 0.5) / n_stations;
    const std::vector<Trace> traces = intersect(surface, facets, axis, across, position);
    if (!group(traces, thickness).empty()) return (i + 1.0) / n_stations;
  }
  return 0;
}

/// Share of the body's width that the crossings of cracks without notch cover.
double share_without_notch(const geometry::Body& body, const CrackSurface& surface) {
  const std::vector<std::size_t> facets = facets_of_notch(surface, -1);
  int n_covered = 0;
  for (int i = 0; i < n_stations && !facets.empty(); ++i) {
    const double position = body.size()[1] * (i + 0.5) / n_stations;
    const std::vector<Trace> traces = intersect(surface, facets, 1, 2, position);
    if (!group(traces, body.size()[0]).empty()) ++n_covered;
  }
  return static_cast<double>(n_covered) / n_stations;
}

/// A notch's path across from its plane: the main crossing at every station, NaN where there is none.
std::vector<double> offsets_from_plane(const geometry::Body& body, const CrackSurface& surface, int notch) {
  const NotchFrame frame = notch_frame(body, notch);
  const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
  std::vector<double> offsets;
  for (int i = 0; i < n_stations; ++i) {
    const double position = frame.tip + frame.direction * frame.ligament * (i + 0.5) / n_stations;
    const std::vector<Trace> traces = intersect(surface, facets, frame.axis, frame.across, position);
    const std::optional<Crossing> crossing = main_crossing(traces, body.size()[0]);
    offsets.push_back(crossing ? crossing->mean - body.notch(notch).at : none);
  }
  return offsets;
}

}  // namespace

std::vector<SectionCrossing> section_crossings(const geometry::Body& body, const CrackSurface& surface,
                                               const input::Sections& sections) {
  std::vector<SectionCrossing> crossings;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const NotchFrame frame = notch_frame(body, notch);
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    for (const input::Section& section : sections.all()) {
      std::optional<Crossing> crossing;
      if (section.axis == frame.axis) {
        const auto traces = intersect(surface, facets, frame.axis, frame.across, section.position);
        crossing = main_crossing(traces, body.size()[0]);
      }
      crossings.push_back(crossing ? SectionCrossing{crossing->mean, crossing->spread, crossing->n_groups}
                                   : SectionCrossing{none, none, 0});
    }
  }
  return crossings;
}

std::vector<double> crossed_shares(const geometry::Body& body, const CrackSurface& surface) {
  std::vector<double> shares;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const NotchFrame frame = notch_frame(body, notch);
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    shares.push_back(farthest_share(surface, facets, frame.axis, frame.across, frame.tip,
                                    frame.direction * frame.ligament, body.size()[0]));
  }
  return shares;
}

double path_overlap(const geometry::Body& body, const CrackSurface& surface, int notch, int other) {
  const NotchFrame frame = notch_frame(body, notch);
  const NotchFrame other_frame = notch_frame(body, other);
  if (frame.axis != other_frame.axis || frame.direction == other_frame.direction) return none;
  const double distance = overlap_distance_share * body.size()[1];
  const std::vector<double> path = offsets_from_plane(body, surface, notch);
  const std::vector<double> turned = offsets_from_plane(body, surface, other);
  int n_reached = 0;
  int n_over = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!std::isnan(path[i]) || !std::isnan(turned[i])) ++n_reached;
    // Turning changes the sign of the way from the notch's plane.
    if (std::abs(path[i] + turned[i]) <= distance) ++n_over;
  }
  return n_reached > 0 ? static_cast<double>(n_over) / n_reached : none;
}

double pattern_overlap(const geometry::Body& body, const CrackSurface& surface) {
  const std::vector<double> shares = crossed_shares(body, surface);
  if (shares.size() < 2) return none;
  std::vector<int> notches(shares.size());
  std::iota(notches.begin(), notches.end(), 0);
  std::stable_sort(notches.begin(), notches.end(), [&](int a, int b) {
    return shares[static_cast<std::size_t>(a)] > shares[static_cast<std::size_t>(b)];
  });
  return path_overlap(body, surface, notches[0], notches[1]);
}

Pattern classify(const geometry::Body& body, const CrackSurface& surface) {
  const std::vector<double> shares = crossed_shares(body, surface);
  if (share_without_notch(body, surface) >= developed_share) return Pattern::other;
  const auto n_developed =
      std::count_if(shares.begin(), shares.end(), [](double s) { return s >= developed_share; });
  const double largest = shares.empty() ? 0 : *std::max_element(shares.begin(), shares.end());
  if (n_developed == 1 && largest >= through_share) return Pattern::one_crack;
  if (n_developed == 2 && !(pattern_overlap(body, surface) < min_overlap)) return Pattern::two_cracks;
  return largest < started_share ? Pattern::none : Pattern::other;
}

}  // namespace crackle::analysis
