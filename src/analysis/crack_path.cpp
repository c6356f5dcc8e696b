// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"

#include "crackle/common/index.h"

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

/// How far a notch's crack has come across its ligament.
struct Advance {
  double share = 0;  ///< of the way, up to the farthest station with a crossing
  double time = std::numeric_limits<double>::infinity();  ///< at which it opened there first [s]
};

Advance advance(const geometry::Body& body, const CrackSurface& surface, int notch) {
  const NotchFrame frame = notch_frame(body, notch);
  const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
  for (int i = n_stations - 1; i >= 0 && !facets.empty(); --i) {
    const double position = frame.tip + frame.direction * frame.ligament * (i + 0.5) / n_stations;
    const std::vector<Trace> traces = intersect(surface, facets, frame.axis, frame.across, position);
    if (const auto crossing = main_crossing(traces, body.size()[0]))
      return {(i + 1.0) / n_stations, crossing->time};
  }
  return {};
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
                                               const CrackArms& arms, const input::Sections& sections) {
  std::vector<SectionCrossing> crossings;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const NotchFrame frame = notch_frame(body, notch);
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    for (const input::Section& section : sections.all()) {
      std::optional<Crossing> crossing;
      if (section.axis == frame.axis) {
        const auto traces = intersect(surface, facets, frame.axis, frame.across, section.position);
        crossing = main_crossing(traces, body.size()[0], arms.arm);
      }
      crossings.push_back(crossing ? SectionCrossing{crossing->mean, crossing->spread, crossing->arms}
                                   : SectionCrossing{none, none, {}});
    }
  }
  return crossings;
}

std::vector<double> crossed_shares(const geometry::Body& body, const CrackSurface& surface) {
  std::vector<double> shares;
  for (int notch = 0; notch < body.n_notches(); ++notch)
    shares.push_back(advance(body, surface, notch).share);
  return shares;
}

int leading_notch(const geometry::Body& body, const CrackSurface& surface) {
  int leading = -1;
  Advance farthest{started_share};
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const Advance found = advance(body, surface, notch);
    if (found.share < farthest.share || (found.share == farthest.share && !(found.time < farthest.time)))
      continue;
    leading = notch;
    farthest = found;
  }
  return leading;
}

std::optional<int> leading_notch(const geometry::Body& body, const input::Sections& sections,
                                 std::span<const double> position) {
  struct Bounds {
    double arrived = 0;  // share of the ligament at the farthest section with a crossing
    double missing = 1;  // at the next section beyond
  };
  const std::vector<input::Section> planes = sections.all();
  std::vector<Bounds> bounds(static_cast<std::size_t>(body.n_notches()));
  for (std::size_t notch = 0; notch < bounds.size(); ++notch) {
    const NotchFrame frame = notch_frame(body, static_cast<int>(notch));
    const auto share = [&](std::size_t i) { return frame.advance(planes[i].position) / frame.ligament; };
    Bounds& found = bounds[notch];
    for (std::size_t i = 0; i < planes.size(); ++i)
      if (!std::isnan(position[notch * planes.size() + i])) found.arrived = std::max(found.arrived, share(i));
    for (std::size_t i = 0; i < planes.size(); ++i)
      if (planes[i].axis == frame.axis && share(i) > found.arrived)
        found.missing = std::min(found.missing, share(i));
  }
  constexpr double rounding = 1e-9;  // of shares at sections that lie symmetrically
  for (std::size_t notch = 0; notch < bounds.size(); ++notch) {
    if (!(bounds[notch].arrived > 0)) continue;
    bool leads = true;
    for (std::size_t other = 0; other < bounds.size(); ++other)
      leads = leads && (other == notch || bounds[notch].arrived >= bounds[other].missing - rounding);
    if (leads) return static_cast<int>(notch);
  }
  return std::nullopt;
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
  std::stable_sort(notches.begin(), notches.end(),
                   [&](int a, int b) { return shares[index(a)] > shares[index(b)]; });
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
