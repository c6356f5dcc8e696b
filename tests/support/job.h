// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"
#include "geometry/subdomain.h"
#include "input/reader.h"
#include "support/box_mesh.h"

#include <filesystem>
#include <string>

namespace crackle::test {

/// An input file from the folder jobs.
inline input::Parameters job(const std::string& file) {
  return input::read(std::filesystem::path(CRACKLE_SOURCE_DIR) / "jobs" / file);
}

/// The mesh made by the program for a sample.
inline geometry::Realization realization(const input::Parameters& parameters, std::uint64_t sample = 0) {
  const auto body = geometry::make_body(parameters);
  const auto base = geometry::make_mother_points(*body, parameters.mesh, parameters.seed);
  return geometry::make_realization(*body, base, parameters.mesh, parameters.seed, sample);
}

}  // namespace crackle::test
