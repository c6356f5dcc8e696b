// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Limits that the reader of the input and what works on it share.
namespace crackle::input {

/// Base mother points, one for each node, that are made at most: a mesh of so many takes some 30 GB while it
/// is made, and its numbers of tetrahedra and facets stay far below 2^31.
inline constexpr double max_mother_points = 2e7;

}  // namespace crackle::input
