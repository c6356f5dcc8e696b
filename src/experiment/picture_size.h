// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <utility>

namespace crackle::experiment {

/// Width and height of a PNG or JPEG file, from its header [pixels].
/// @throws std::runtime_error with the reason when it is neither
std::pair<int, int> picture_size(const std::filesystem::path& file);

}  // namespace crackle::experiment
