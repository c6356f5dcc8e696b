// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace crackle::apps {

/// An example input shipped with the program.
struct Problem {
  std::string name;  ///< of its file in jobs/, jobs/gallery/ or jobs/verification/, without ".toml"
  std::string text;
};

/// All of them, no two of the same name.
const std::vector<Problem>& problems();

}  // namespace crackle::apps
