// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/mother_points.h"
#include "crackle/input/parameters.h"

#include <filesystem>

namespace crackle::ensemble {

/// The base mother points of an ensemble: those in folder/ensemble.h5 when that file belongs to this input,
/// made anew otherwise. Not collective.
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints base_points(const std::filesystem::path& folder, const input::Parameters& parameters);

}  // namespace crackle::ensemble
