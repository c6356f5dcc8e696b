// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace crackle::ensemble {

/// That placing so many mother points takes its time, and about how long; empty for a few seconds or less.
std::string waiting_notice(double n_mother_points);

/// Time of one core for placing so many mother points [s].
double placing_seconds(double n_mother_points);

/// Makes the base mother points of an ensemble or, with mesh.base own, of a sample. Not collective.
/// @param say receives the waiting_notice beforehand
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints make_base_points(const geometry::Body& body, const input::Parameters& parameters,
                                        const std::function<void(const std::string&)>& say = {},
                                        std::uint64_t sample = 0);

/// The base mother points that all samples of an ensemble share, none with mesh.base own: but then the number
/// that each sample will have is looked at. Not collective.
/// @param say receives the waiting_notice and the expected number of points beforehand
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints make_shared_points(const geometry::Body& body, const input::Parameters& parameters,
                                          const std::function<void(const std::string&)>& say = {});

/// The realization of a sample, from the points that all share or, with mesh.base own, from points that are
/// made for it now. Not collective.
/// @throws std::runtime_error as geometry::make_mother_points and make_realization
geometry::Realization make_sample_mesh(const geometry::Body& body, const geometry::MotherPoints& shared,
                                       const input::Parameters& parameters, std::uint64_t sample,
                                       int attempt = 0);

/// The base mother points that all samples of an ensemble share: those in folder/ensemble.h5 when that file
/// belongs to this input, made anew otherwise; none with mesh.base own. Not collective.
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints base_points(const std::filesystem::path& folder, const input::Parameters& parameters);

}  // namespace crackle::ensemble
