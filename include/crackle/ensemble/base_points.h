// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/mother_points.h"
#include "crackle/input/parameters.h"

#include <filesystem>
#include <functional>
#include <string>

namespace crackle::ensemble {

/// That placing so many mother points takes its time, and about how long; empty for a few seconds or less.
std::string waiting_notice(double n_mother_points);

/// Makes the base mother points of an ensemble. Not collective.
/// @param say hears the waiting_notice before
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints make_base_points(const geometry::Body& body, const input::Parameters& parameters,
                                        const std::function<void(const std::string&)>& say = {});

/// The base mother points of an ensemble: those in folder/ensemble.h5 when that file belongs to this input,
/// made anew otherwise. Not collective.
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints base_points(const std::filesystem::path& folder, const input::Parameters& parameters);

}  // namespace crackle::ensemble
