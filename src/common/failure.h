// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace crackle {

/// @throws Exception with the formatted message
template <class Exception = std::runtime_error, class... Arguments>
[[noreturn]] void fail(fmt::format_string<Arguments...> message, Arguments&&... arguments) {
  throw Exception(fmt::format(message, std::forward<Arguments>(arguments)...));
}

}  // namespace crackle
