// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::analysis {

/// Where the cracks of one notch cross one section y = const.
struct SectionCrossing {
  double z;  ///< through-thickness mean of the main crossing [m]; NaN where the crack did not arrive
  std::int32_t branches;  ///< number of separate crossings
};

/// Crossings for every notch and section, row-major: [notch * n_sections + section].
std::vector<SectionCrossing> section_crossings(const geometry::Body& body, const CrackSurface& surface,
                                               std::span<const double> sections);

/// The crack pattern of a sample, as stored in /samples/pattern.
enum class Pattern : std::int32_t { none = 0, one_crack = 1, two_cracks = 2, other = 3 };

/// Pattern by the documented rule: how far each notch's crack runs across the width.
Pattern classify(const geometry::Body& body, const CrackSurface& surface);

/// Number of places where a crack parts in two branches.
std::int32_t count_bifurcations(const geometry::Body& body, const CrackSurface& surface);

/// Largest speed of the crack fronts across the width, from a smoothed front position [m/s].
double max_crack_speed(const geometry::Body& body, const CrackSurface& surface);

}  // namespace crackle::analysis
