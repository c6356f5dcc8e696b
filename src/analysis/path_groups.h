// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/statistics.h"
#include "common/quantity_text.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Groups of samples whose cracks take different paths, such as above or below a disc: where positions are in
/// groups with a gap between them, the mean of all is a place where no crack is.
///
/// At a section, sorted positions are divided at a gap if that is too wide for samples of one path, in units
/// of the standard deviation within both parts (the gap test of Tukey, Biometrics 5, 1949, 99, with the
/// deviation within clusters as in Engelman and Hartigan, J. Am. Stat. Assoc. 64, 1969, 1647). A gap beside a
/// single position counts half, as extreme values lie apart. The critical widths are percentage points, by
/// simulation, of the widest gap in normal and in uniform samples, whichever is larger: either is divided in
/// at most the share false_division_rate at one section, hence at m sections in at most m times that. Equal
/// positions count once; fewer than least_for_groups are not divided.
///
/// Groups hold along the whole path: the section with the clearest gap divides the samples, then each part is
/// divided likewise; three equally large groups at equal distances hide each other. A sample that does not
/// reach that section belongs to the part with the nearest mean at the section where the parts differ most,
/// or to none if it reaches no section where they are apart.
namespace crackle::analysis {

inline constexpr double false_division_rate = 0.002;
inline constexpr std::size_t least_for_groups = 4;

/// Where values are divided.
struct Division {
  double clarity;       ///< width of the gap over the critical one; they are divided if it is above 1
  double below, above;  ///< values at the ends of the gap
};

/// The clearest gap in values without NaN, whether or not it divides them; empty if none can be judged.
std::optional<Division> clearest_gap(std::vector<double> values);

/// The group of each sample: 0, 1 ... in ascending order where the first division was made; -1 for none.
/// @param paths for each sample its position at each section; NaN where it has none
std::vector<int> path_groups(const std::vector<std::vector<double>>& paths);

/// True if groups are apart there: by more than the standard deviation within them, or because only some
/// groups have positions there.
/// @param values positions of each group
bool are_apart(const std::vector<std::vector<double>>& values);

/// For each section whether these groups are apart there.
/// @param group of each sample, see path_groups
std::vector<std::uint8_t> divided_sections(const std::vector<std::vector<double>>& paths,
                                           const std::vector<int>& group);

/// The groups of leading and following cracks at the sections where they are apart, as a readable table;
/// empty without groups.
/// @param unit of positions
std::string groups_text(const Statistics& statistics, const input::Sections& sections, const ShownUnit& unit);

/// Which holes the leading cracks ran into and whether they go on from them, as sentences; empty if none did.
std::string holes_text(std::span<const SampleSummary> samples, const std::vector<std::string>& start_names);

}  // namespace crackle::analysis
