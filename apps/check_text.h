// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/quantity_text.h"

#include <fmt/format.h>

#include <string>

/// Texts of `crackle check`.
namespace crackle::apps {

inline std::string duration_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  return seconds < 7200 ? fmt::format("{:.3g} min", seconds / 60) : fmt::format("{:.3g} h", seconds / 3600);
}

inline std::string length_text(double length) {
  return quantity_text(length, "m");
}

inline std::string time_text(double time) {
  return quantity_text(time, "s");
}

}  // namespace crackle::apps
