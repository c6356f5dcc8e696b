// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/mother_points.h"
#include "geometry/realization.h"
#include "input/parameters.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace crackle::ensemble {

/// Generates the base mother points of an ensemble or, with mesh.base = "own", of a single sample. Not
/// collective.
/// @param say told every few seconds what is done
/// @param attempt at the sample's mesh, from 0; counts with mesh.base = "own"
/// @param crew as of geometry::make_mother_points
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints make_base_points(const geometry::Body& body, const input::Mesh& mesh,
                                        std::uint64_t seed,
                                        const std::function<void(const std::string&)>& say = {},
                                        std::uint64_t sample = 0, int attempt = 0,
                                        geometry::Crew* crew = nullptr);

/// The base mother points shared by all samples of an ensemble. With mesh.base = "own" there are none; only
/// the expected number per sample is checked. Not collective.
/// @param say receives the number of points, with mesh.base = "own" the expected one
/// @param crew as of geometry::make_mother_points
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints make_shared_points(const geometry::Body& body, const input::Mesh& mesh,
                                          std::uint64_t seed,
                                          const std::function<void(const std::string&)>& say = {},
                                          geometry::Crew* crew = nullptr);

/// The mesh of a sample, from the shared points or, with mesh.base = "own", from newly generated ones. Not
/// collective.
/// @throws std::runtime_error as geometry::make_mother_points and make_realization
geometry::Realization make_sample_mesh(const geometry::Body& body, const geometry::MotherPoints& shared,
                                       const input::Mesh& mesh, std::uint64_t seed, std::uint64_t sample,
                                       int attempt = 0);

/// Gives a sample's mesh the materials of the input's raster, and its pre-cracks and flaws.
/// @throws std::runtime_error as apply_material_map and geometry::drawn_flaws
void complete_realization(const input::Model& model, const geometry::Body& body, std::uint64_t sample,
                          geometry::Realization& realization);

/// The realization of a sample: its mesh, with up to three attempts, completed.
/// Not collective.
/// @throws std::runtime_error with the reason of each attempt, or as complete_realization
geometry::Realization make_sample_realization(const geometry::Body& body,
                                              const geometry::MotherPoints& shared, const input::Model& model,
                                              std::uint64_t sample);

/// The base mother points shared by all samples of an ensemble: read from folder/ensemble.h5 if that file
/// belongs to this input, otherwise regenerated; none with mesh.base = "own". Not collective.
/// @throws std::runtime_error as geometry::make_mother_points
geometry::MotherPoints base_points(const std::filesystem::path& folder, const input::Parameters& parameters);

}  // namespace crackle::ensemble
