// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>

namespace crackle::test {

/// The number in an environment variable, or `fallback` without one.
inline double from_environment(const char* name, double fallback) {
  const char* const text = std::getenv(name);
  return text != nullptr ? std::strtod(text, nullptr) : fallback;
}

/// Whether this is tools/check --full, which sets CRACKLE_FULL.
inline bool is_full() {
  return std::getenv("CRACKLE_FULL") != nullptr;
}

/// A number of repetitions: `full` under tools/check --full, else `usual`.
inline int repetitions(int usual, int full) {
  return is_full() ? full : usual;
}

}  // namespace crackle::test
