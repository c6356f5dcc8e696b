// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <concepts>
#include <cstddef>
#include <type_traits>

namespace crackle {

/// Converts a number, such as that of a node or of a face, to an array index. @pre number >= 0
template <class Number>
requires std::integral<Number> || std::is_enum_v<Number>
constexpr std::size_t index(Number number) {
  return static_cast<std::size_t>(number);
}

/// Array index of a node's component, with three values per node.
constexpr std::size_t index(std::integral auto node, std::integral auto component) {
  return 3 * index(node) + index(component);
}

}  // namespace crackle
