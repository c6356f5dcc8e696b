// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/study.h"

#include <string>
#include <vector>

namespace crackle::input {

/// Keys whose values change together from case to case.
struct Sweep {
  std::vector<std::string> keys;
  std::vector<std::vector<std::string>> values;  ///< by case and key, in TOML
};

/// The typed, immutable parameters of an ensemble, with the file that gave them.
struct Parameters : Study {
  /// The input file as it was read, with the points of an outline file.
  std::string text;
  std::vector<std::string> notes = {};  ///< on the file, such as keys without effect
  std::vector<Sweep> sweeps = {};
};

}  // namespace crackle::input
