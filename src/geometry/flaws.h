// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "input/model.h"
#include "plane/plate.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The random flaws of a sample, those of one table after those of the other; depends on (seed, sample) and
/// the tables only.
/// @throws std::runtime_error when a region contains hardly any part of the body
std::vector<plane::PreCrack> drawn_flaws(const input::Model& model, const Body& body, std::uint64_t sample);

/// The pre-cracks of a sample: those of the input, then its flaws.
std::vector<plane::PreCrack> pre_cracks(const input::Model& model, const Body& body, std::uint64_t sample);

}  // namespace crackle::geometry
