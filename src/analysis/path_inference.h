// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/grouped_values.h"
#include "analysis/leader_frame.h"
#include "analysis/statistics.h"

#include <span>
#include <string>
#include <vector>

/// Crack paths as wholes: bands that hold at all sections at once, and the cracks that stop before a section,
/// which its mean leaves out.
namespace crackle::analysis {

/// A crack's positions at all sections.
using FramedPath = std::vector<FramedPosition>;

/// Half widths of a band that holds the mean at all sections at once [m]; NaN where fewer than two groups
/// arrived. Student's t at one level for all sections, at which the largest studentized deviation keeps the
/// confidence: by normal multipliers of the groups' residuals, which have the sections' correlation (Montiel
/// Olea and Plagborg-Moller 2019, J. Appl. Econometrics 34, 1); 4000 of them, the same in every call.
std::vector<double> band_half_widths(std::span<const FramedPath> paths, Groups groups, double confidence);

/// For each section, the one that a crack reaches before it: the neighbour of the same axis on the side of
/// the section that most cracks reach; -1 for that section, and for lines.
std::vector<int> previous_sections(const input::Sections& sections, std::span<const FramedPath> paths);

/// The cracks that reach the section before, by whether they reach this one; without leaders that separated
/// their body elsewhere.
struct Stopped {
  int previous = -1;  ///< see previous_sections; without it the rest is undefined
  int n_arrived = 0, n_stopped = 0;
  double mean_arrived = not_a_number;  ///< at the section before, of those that arrive here [m]
  double mean_stopped = not_a_number;  ///< likewise, of those that stop
  /// p of the difference, by permutations. NaN if a group has several cracks: some may arrive and others
  /// stop, while the units that are permuted must be independent.
  double probability = not_a_number;
  /// Mean here had no crack stopped [m]. Positions of those that stopped are predicted by linear regression
  /// on the section before, section after section: for normal positions that depend on the section before
  /// alone, the maximum-likelihood estimate from monotone missing data (Anderson 1957, J. Am. Stat. Assoc.
  /// 52, 200). It assumes that a crack stops by where it is, not by where it would have gone. NaN with fewer
  /// than 5 arrivals.
  double mean_of_all = not_a_number;
  double half_width_of_all = not_a_number;  ///< of its interval: jackknife over groups, Student's t [m]
  int n_all = 0;                            ///< cracks in this mean
  int n_predicted = 0;                      ///< of these
  int n_beyond = 0;  ///< of the predicted, outside the range of the arrivals one section earlier
};

/// For each section.
std::vector<Stopped> stopped_cracks(std::span<const FramedPath> paths, std::span<const int> previous,
                                    Groups groups, double confidence);

/// Rows and sections as in RankStatistics.
struct PathInference {
  std::vector<double> band_half_width;
  std::vector<Stopped> stopped;
};

/// For the leaders or the followers of statistics over these samples.
PathInference path_inference(const RankStatistics& ranks, const Statistics& statistics,
                             std::span<const SampleSummary> samples, const LeaderFrame& frame,
                             const input::Sections& sections);

/// The same for leaders and followers as a readable table; empty if no crack reached a section.
std::string path_inference_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                                const input::Study& study);

}  // namespace crackle::analysis
