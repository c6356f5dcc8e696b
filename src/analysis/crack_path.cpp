// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"

#include "crossings.h"

#include <algorithm>
#include <limits>

namespace crackle::analysis {

namespace {

constexpr int n_stations = 50;  // of crossed_shares

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

}  // namespace

std::vector<SectionCrossing> section_crossings(const geometry::Body& body, const CrackSurface& surface,
                                               std::span<const double> sections) {
  std::vector<SectionCrossing> crossings;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const bool has_crossings = notch_frame(body, notch).axis == 1;
    const std::vector<std::size_t> facets =
        has_crossings ? facets_of_notch(surface, notch) : std::vector<std::size_t>{};
    for (const double y : sections) {
      const std::vector<Trace> traces = intersect(surface, facets, 1, 2, y);
      const auto groups = group(traces, body.size()[0]);
      SectionCrossing crossing{std::numeric_limits<double>::quiet_NaN(),
                               static_cast<std::int32_t>(groups.size())};
      // Traces are in order of breaking and groups in order of their first trace, so of groups that cover
      // the same length the earliest stays.
      double longest = 0;
      for (const auto& members : groups) {
        const double length = covered(traces, members);
        if (length <= longest) continue;
        longest = length;
        crossing.z = mean_across(traces, members);
      }
      crossings.push_back(crossing);
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

Pattern classify(const geometry::Body& body, const CrackSurface& surface) {
  const std::vector<double> shares = crossed_shares(body, surface);
  if (share_without_notch(body, surface) >= developed_share) return Pattern::other;
  const auto n_developed =
      std::count_if(shares.begin(), shares.end(), [](double s) { return s >= developed_share; });
  const double largest = shares.empty() ? 0 : *std::max_element(shares.begin(), shares.end());
  if (n_developed == 1 && largest >= through_share) return Pattern::one_crack;
  if (n_developed == 2) return Pattern::two_cracks;
  return largest < started_share ? Pattern::none : Pattern::other;
}

}  // namespace crackle::analysis
