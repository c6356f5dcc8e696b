// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/sample_result.h"

#include "crackle/common/index.h"

#include <array>

namespace crackle::dynamics {

std::string to_string(Outcome outcome) {
  constexpr std::array names{"unbroken", "arrested", "separated", "in one piece", "undecided"};
  return names.at(index(outcome));
}

}  // namespace crackle::dynamics
