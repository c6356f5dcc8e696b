// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel_command.h"

#include "crackle/parallel/agreement.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string_view>

namespace crackle::apps {

namespace {

/// Columns of a terminal; 0 for anything else and for pseudo-terminals that nobody looks at.
int columns(int descriptor) {
  winsize size{};
  if (isatty(descriptor) == 0 || ioctl(descriptor, TIOCGWINSZ, &size) != 0) return 0;
  return size.ws_col;
}

}  // namespace

int terminal_width(int stream) {
  if (isatty(stream) == 0) return 0;
  if (const int width = columns(stream); width > 0) return width;
  const std::string launcher_output = fmt::format("/proc/{}/fd/{}", getppid(), stream);
  const int descriptor = open(launcher_output.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) return 0;
  const int width = columns(descriptor);
  close(descriptor);
  return width;
}

void add_parking_options(CLI::App& command, ParkingOptions& options) {
  static const std::map<std::string, double> time_units{{"s", 1}, {"min", 60}, {"h", 3600}, {"d", 86400}};
  const CLI::Validator is_positive(
      [](const std::string& text) -> std::string {
        return std::strtod(text.c_str(), nullptr) > 0 ? "" : "give a time above 0, such as 8h";
      },
      "");
  command
      .add_option("--time-limit", options.time_limit,
                  "park samples under way and stop within this time, such as 8h; in a SLURM job "
                  "the end of the job is a limit too")
      ->transform(CLI::AsNumberWithUnit(time_units))
      ->check(is_positive);
  command
      .add_option("--checkpoint-interval", options.checkpoint_interval,
                  "write a checkpoint of each sample this often, such as 30min; default: only when it is "
                  "parked")
      ->transform(CLI::AsNumberWithUnit(time_units))
      ->check(is_positive);
}

std::string shell_line(std::span<const std::string> words) {
  constexpr std::string_view plain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_@%+=:,./-";
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

std::string continuation(const CommandLine& typed, const std::string& option) {
  CommandLine words = typed;
  std::erase_if(words, [](const std::string& word) {
    return word == "--resume" || word == "--retry-failed" || word == "--overwrite";
  });
  words.push_back(option);
  return shell_line(words);
}

int end_together(const parallel::Communicator& world, const std::function<int()>& work) {
  try {
    return work();
  } catch (const parallel::AgreedError&) {
    throw;
  } catch (const std::exception& error) {
    fmt::print(stderr, "crackle: rank {}: {}\n", world.rank(), error.what());
    std::fflush(nullptr);
    if (world.size() > 1) MPI_Abort(world.get(), internal_failure);
    return internal_failure;
  }
}

}  // namespace crackle::apps
