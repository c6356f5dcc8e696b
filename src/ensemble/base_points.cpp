// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/base_points.h"

#include "crackle/ensemble/results.h"
#include "crackle/io/ensemble_file.h"

#include <stdexcept>

namespace crackle::ensemble {

geometry::MotherPoints base_points(const std::filesystem::path& folder, const input::Parameters& parameters) {
  try {
    return io::read_mother_points(results_file(folder), parameters);
  } catch (const std::runtime_error&) {
    return geometry::make_mother_points(geometry::Body(parameters.specimen), parameters.mesh,
                                        parameters.ensemble.seed);
  }
}

}  // namespace crackle::ensemble
