// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace crackle::geometry {

/// Tolerance of coordinates on faces and edges, relative to the body's largest size.
inline constexpr double wall_tolerance = 1e-12;

/// Corners closer than this share of the body's size are merged.
inline constexpr double merging_share = 1e-6;

/// The shape does not refine a mesh that is nearly fine enough.
inline constexpr double fine_enough = 1.25;

}  // namespace crackle::geometry
