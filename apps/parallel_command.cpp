// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel_command.h"

#include "common/failure.h"
#include "common/whole_number.h"
#include "parallel/agreement.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

/// Columns of a terminal; 0 for anything else and for pseudo-terminals without a size.
int columns(int descriptor) {
  winsize size{};
  if (isatty(descriptor) == 0 || ioctl(descriptor, TIOCGWINSZ, &size) != 0) return 0;
  return size.ws_col;
}

constexpr double minute = 60, hour = 3600, day = 86400;  // [s]

/// "8h", "30 min", "90"
std::optional<double> seconds_with_unit(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, double>, 7> units{
      {{"", 1}, {"s", 1}, {"m", minute}, {"min", minute}, {"h", hour}, {"d", day}, {"days", day}}};
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
  for (const auto& [name, seconds] : units)
    if (unit == name) return number * seconds;
  return std::nullopt;
}

/// "2-12:30:00"; without days the last number is seconds, with days the first number after them is hours.
std::optional<double> as_slurm_writes(std::string_view text) {
  const std::size_t dash = text.find('-');
  const auto days =
      dash == std::string_view::npos ? std::optional(0) : whole_number<int>(text.substr(0, dash));
  std::string_view rest = dash == std::string_view::npos ? text : text.substr(dash + 1);
  std::vector<double> numbers;
  for (bool is_last = false; !is_last;) {
    const std::size_t colon = rest.find(':');
    is_last = colon == std::string_view::npos;
    const auto number = whole_number<int>(rest.substr(0, colon));
    if (!number || *number < 0) return std::nullopt;
    numbers.push_back(*number);
    if (!is_last) rest.remove_prefix(colon + 1);
  }
  if (!days || *days < 0 || numbers.size() > 3) return std::nullopt;
  if (dash == std::string_view::npos && numbers.size() == 2) numbers.insert(numbers.begin(), 0);
  numbers.resize(3);
  return *days * day + numbers[0] * hour + numbers[1] * minute + numbers[2];
}

/// A number from one of a launcher's variables; 0 if unset.
int told_by_launcher(const char* variable) {
  const char* value = std::getenv(variable);
  return whole_number<int>(value != nullptr ? value : "").value_or(0);
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

std::optional<double> duration(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool has_unit = std::ranges::any_of(lower, [](unsigned char c) { return std::isalpha(c) != 0; });
  const bool is_of_slurm = !has_unit && lower.find_first_of(":-") != std::string::npos;
  const auto seconds = is_of_slurm ? as_slurm_writes(lower) : seconds_with_unit(lower);
  return seconds && *seconds > 0 && std::isfinite(*seconds) ? seconds : std::nullopt;
}

void check_tasks(const parallel::Communicator& world, bool is_whole) {
  if (world.size() > 1 || std::getenv("SLURM_PROCID") == nullptr) return;
  const char* const advice = "start the ranks with mpirun, or with srun --mpi=pmix where SLURM has it";
  if (const int n = told_by_launcher("SLURM_STEP_NUM_TASKS"); n > 1) {
    const std::string found =
        fmt::format("srun started {} tasks, but MPI sees only 1: each would be a separate run", n);
    // Does not apply to the shell of srun --pty, whose other tasks have ended.
    const bool is_task = told_by_launcher("SLURM_TASK_PID") == ::getpid();
    if (is_whole && is_task) fail("{}; {}", found, advice);
    fmt::print(stderr, "crackle: {}; if they are to be ranks of one run, {}\n", found, advice);
  } else if (const int n_in_job = told_by_launcher("SLURM_NTASKS"); n_in_job > 1) {
    fmt::print(stderr, "crackle: the SLURM job has {} tasks, and this run uses 1; {}\n", n_in_job, advice);
  }
}

bool has_other_ranks() {
  // Those of Open MPI, of MPICH and its kin, and of SLURM's srun.
  constexpr std::array variables{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"};
  return std::ranges::any_of(variables, [](const char* name) { return told_by_launcher(name) > 1; });
}

void add_suspend_options(CLI::App& command, SuspendOptions& options) {
  const CLI::Validator as_seconds(
      [](std::string& text) -> std::string {
        const auto seconds = duration(text);
        if (!seconds)
          return fmt::format(
              "'{}' is not a time above 0; give one such as 90s, 30min, 8h, 2d, 8:00:00 (H:MM:SS), 30:00 "
              "(M:SS) or "
              "1-12:00:00 (D-HH:MM:SS)",
              text);
        text = fmt::format("{}", *seconds);
        return {};
      },
      "");
  command
      .add_option("--time-limit", options.time_limit,
                  "suspend samples under way and stop within this time, such as 8h, 30min, 90s or, as SLURM "
                  "writes it, 8:00:00; in a SLURM job the end of the job is a limit too")
      ->transform(as_seconds)
      ->type_name("TIME");
  command
      .add_option(
          "--checkpoint-interval", options.checkpoint_interval,
          "write a checkpoint of each sample this often, such as 30min or 30:00; default: only when it "
          "is suspended")
      ->transform(as_seconds)
      ->type_name("TIME");
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

int exit_status(const ensemble::RunOutcome& outcome) {
  if (outcome.stopped) return stopped_resumable;
  const bool is_complete = outcome.failed == 0 && outcome.left == 0 && outcome.file_error.empty();
  return is_complete ? success : some_samples_failed;
}

int end_collectively(const parallel::Communicator& world, const std::function<int()>& work) {
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
