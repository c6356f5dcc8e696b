// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>

namespace crackle {

/// The known name that is spelled most like `name`, for "did you mean"; empty if none is alike.
std::optional<std::string> nearest_name(const std::string& name, std::span<const std::string> known);

}  // namespace crackle
