// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <string>
#include <system_error>

namespace crackle::apps {

CLI::Option* add_sample_option(CLI::App& command, std::uint64_t& sample) {
  return command.add_option("--sample", sample, "number of the sample, from 0")
      ->check([](const std::string& text) {
        std::uint64_t number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        const bool whole = error == std::errc{} && end == text.data() + text.size();
        return whole ? std::string() : "'" + text + "' is no sample number; give a whole number from 0 on";
      });
}

}  // namespace crackle::apps
