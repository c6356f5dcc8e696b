// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/experiment/observation.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <filesystem>

namespace crackle::apps {

/// The samples of an ensemble as experiments see them.
/// @param with_arms also their cracks, from the sample files
/// @throws std::runtime_error when these are needed and missing, or no sample is done
experiment::ObservedSamples observed_samples(const std::filesystem::path& folder,
                                             const input::Parameters& parameters, const geometry::Body& body,
                                             bool with_arms);

}  // namespace crackle::apps
