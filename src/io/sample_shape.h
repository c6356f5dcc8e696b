// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"
#include "hdf5.h"

/// What writing and reading of sample files share.
namespace crackle::io {

inline constexpr const char* sample_kind = "crackle sample";
inline constexpr const char* ensemble_kind = "crackle ensemble";

/// Of the results at the sections: crack starts x sections.
inline hdf5::Shape position_shape(const input::Parameters& parameters) {
  return {geometry::n_crack_starts(parameters.specimen), parameters.sections.size()};
}

}  // namespace crackle::io
