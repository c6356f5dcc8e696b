// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <filesystem>

namespace crackle::apps {

/// The input that the ensemble in `folder` was started with: the run's copy of it, or what its results hold.
/// Collective.
/// @throws parallel::AgreedError on every rank when the folder holds no ensemble
input::Parameters input_of(const parallel::Communicator& world, const std::filesystem::path& folder);

}  // namespace crackle::apps
