// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands.h"

#include <fmt/format.h>

#include <cstdio>

namespace crackle::apps {

void notify(const std::string& line) {
  fmt::print(stderr, "{}\n", line);
}

}  // namespace crackle::apps
