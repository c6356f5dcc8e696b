// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace crackle::apps {

/// An example input shipped with the program.
struct Problem {
  std::string name;  ///< of its file in jobs/ or jobs/gallery/, without ".toml"
  std::string text;
};

/// Sorted by file name.
const std::vector<Problem>& problems();

}  // namespace crackle::apps
