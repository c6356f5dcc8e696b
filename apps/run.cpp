// SPDX-License-Identifier: GPL-3.0-or-later
// crackle run: runs the ensemble.
#include "ensemble/run.h"
#include "common/failure.h"
#include "common/whole_number.h"
#include "parallel/agreement.h"

#include "parallel_command.h"

#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace crackle::apps {

namespace {

struct RunArguments {
  std::filesystem::path input;
  std::filesystem::path folder;
  bool resume = false;
  bool retry_failed = false;
  std::string samples;
  std::string part;
  SuspendOptions suspend;
};

/// "12" or "0-49"; empty for an empty text.
std::optional<ensemble::SampleRange> sample_range(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const std::string_view all = text;
  const auto dash = all.find('-');
  const auto first = whole_number<std::uint64_t>(all.substr(0, dash));
  const auto last =
      dash == std::string_view::npos ? first : whole_number<std::uint64_t>(all.substr(dash + 1));
  if (first && last) return ensemble::SampleRange{*first, *last};
  throw CLI::ValidationError("'" + text + "' is not a range; give one such as 0-49");
}

/// A part of the samples, as given on the command line.
struct Part {
  std::uint64_t number = 0;  ///< from 0
  std::uint64_t n_parts = 1;
};

/// "3/20"; the range depends on the input.
Part part(const std::string& text) {
  const std::string_view all = text;
  const auto slash = all.find('/');
  const auto k = whole_number<std::uint64_t>(all.substr(0, slash));
  const auto n =
      slash == std::string_view::npos ? std::nullopt : whole_number<std::uint64_t>(all.substr(slash + 1));
  if (!k || !n)
    throw CLI::ValidationError("'" + text + "' is not a part; give one such as 0/20, the first of 20");
  if (*k >= *n)
    throw CLI::ValidationError("there is no part " + text +
                               ": parts are numbered from 0, the last of N is N-1/N");
  return {*k, *n};
}

/// The samples selected by the options; empty: all. Collective.
/// @throws parallel::AgreedError when there are more parts than samples, or when cases differ in their number
///   of samples
std::optional<ensemble::SampleRange> chosen_range(const parallel::Communicator& world,
                                                  const input::Parameters& parameters,
                                                  const std::vector<input::Case>& cases,
                                                  const RunArguments& arguments) {
  if (arguments.part.empty()) return sample_range(arguments.samples);
  return parallel::agree(world, [&] {
    const auto [number, n_parts] = part(arguments.part);
    const int n_samples =
        cases.empty() ? parameters.ensemble.samples : cases.front().parameters.ensemble.samples;
    for (const input::Case& one : cases)
      if (one.parameters.ensemble.samples != n_samples)
        fail(
            "--part: the cases of this sweep differ in ensemble.samples; give --samples, or run each of them "
            "alone");
    return ensemble::part_of_samples(number, n_parts, static_cast<std::uint64_t>(n_samples));
  });
}

/// The command of the report: where the program is installed that lies beside it, else in the source tree.
std::string report_command() {
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const bool is_installed = std::filesystem::exists(program.parent_path() / "crackle-report", ignored);
  return is_installed ? "crackle-report" : "tools/crackle-report";
}

int run_command(const parallel::Communicator& world, const input::Parameters& parameters,
                const std::vector<input::Case>& cases, const RunArguments& arguments,
                const CommandLine& typed) {
  const ensemble::RunOptions options{
      .folder = arguments.folder,
      .plan = {.resume = arguments.resume || arguments.retry_failed,
               .retry_failed = arguments.retry_failed,
               .range = chosen_range(world, parameters, cases, arguments)},
      .log = &std::cout,
      .terminal_width = terminal_width(STDOUT_FILENO),
      .stop = ensemble::make_stop_request(arguments.suspend.time_limit, world.is_root()),
      .checkpoint_interval = arguments.suspend.checkpoint_interval,
      .next = {.resume = continuation(typed, "--resume"),
               .retry_failed = continuation(typed, "--retry-failed"),
               .report = report_command() + " " + shell_line({{arguments.folder.string()}})},
  };
  return exit_status(ensemble::run(world, parameters, cases, options));
}

}  // namespace

void add_run_command(CLI::App& app, const CommandLine& typed, Action& run) {
  auto arguments = std::make_shared<RunArguments>();
  auto* command = app.add_subcommand(
      "run", "Run the ensemble: rank 0 is the master, the other ranks form groups of ranks_per_sample");
  command->add_option("input", arguments->input, "input file (TOML)")->required();
  command->add_option("-o,--output", arguments->folder, "folder for the results")->required();
  command->add_flag("--resume", arguments->resume,
                    "continue the ensemble in the folder; finished samples are kept");
  command->add_flag("--retry-failed", arguments->retry_failed,
                    "like --resume, but compute failed samples again");
  const auto checked = [](const auto& parse) {
    return [parse](const std::string& text) {
      try {
        parse(text);
        return std::string();
      } catch (const CLI::ValidationError& error) {
        return std::string(error.what());
      }
    };
  };
  CLI::Option* samples = command
                             ->add_option("--samples", arguments->samples,
                                          "compute only this range of samples, such as 0-49; other runs can "
                                          "compute other ranges in the same folder, with --resume once it is "
                                          "there")
                             ->check(checked(sample_range));
  command
      ->add_option("--part", arguments->part,
                   "compute only part K of N parts of about equal size, given as K/N with K from 0 to N-1, "
                   "such as 0/20; like --samples, for job arrays")
      ->check(checked(part))
      ->excludes(samples);
  add_suspend_options(*command, arguments->suspend);
  command->footer(std::string("Exit status: 0 all samples done; 1 usage or input error, nothing was written; "
                              "2 finished, but some "
                              "samples failed; 3 stopped early, continue with --resume; ") +
                  crash_help + signals_help);
  command->callback([arguments, typed, &run] {
    run.needs_mpi = true;
    run.work = [arguments, typed](const parallel::Communicator& world) {
      parallel::agree(world,
                      [&] { check_tasks(world, arguments->samples.empty() && arguments->part.empty()); });
      const input::Parameters parameters = read_given_input(world, arguments->input);
      std::vector<input::Case> cases;
      if (!parameters.sweeps.empty()) cases = read_cases(world, parameters, arguments->input);
      return end_collectively(world,
                              [&] { return run_command(world, parameters, cases, *arguments, typed); });
    };
  });
}

}  // namespace crackle::apps
