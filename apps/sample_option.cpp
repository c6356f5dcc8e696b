// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/whole_number.h"

#include "commands.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>

namespace crackle::apps {

CLI::Option* add_sample_option(CLI::App& command, std::uint64_t& sample) {
  return command.add_option("--sample", sample, "number of the sample, from 0")
      ->check([](const std::string& text) {
        return whole_number<std::uint64_t>(text)
                   ? std::string()
                   : "'" + text + "' is not a sample number; give a whole number from 0 on";
      });
}

}  // namespace crackle::apps
