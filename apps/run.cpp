// SPDX-License-Identifier: GPL-3.0-or-later
// crackle run: the ensemble.
#include "crackle/dynamics/sample_run.h"
#include "crackle/ensemble/ensemble_run.h"
#include "parallel_command.h"

#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cctype>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

namespace crackle::apps {

namespace {

struct Arguments {
  std::filesystem::path input;
  std::filesystem::path folder;
  bool resume = false;
  bool retry_failed = false;
  std::string samples;
  ParkingOptions parking;
};

/// "12" or "0-49"; an empty text is no range.
std::optional<ensemble::SampleRange> sample_range(const std::string& text) {
  if (text.empty()) return std::nullopt;
  ensemble::SampleRange range;
  int end = 0;
  if (std::isdigit(static_cast<unsigned char>(text.front())) != 0) {
    if (std::sscanf(text.c_str(), "%lu-%lu%n", &range.first, &range.last, &end) == 2 &&
        static_cast<std::size_t>(end) == text.size())
      return range;
    if (std::sscanf(text.c_str(), "%lu%n", &range.first, &end) == 1 &&
        static_cast<std::size_t>(end) == text.size())
      return ensemble::SampleRange{range.first, range.first};
  }
  throw CLI::ValidationError("--samples: '" + text + "' is no range; give one such as 0-49");
}

int run_command(const parallel::Communicator& world, const input::Parameters& parameters,
                const Arguments& arguments) {
  const ensemble::RunOptions options{
      .folder = arguments.folder,
      .plan = {.resume = arguments.resume || arguments.retry_failed,
               .retry_failed = arguments.retry_failed,
               .range = sample_range(arguments.samples)},
      .log = &std::cout,
      .terminal_width = terminal_width(STDOUT_FILENO),
      .stop = ensemble::make_stop_request(arguments.parking.time_limit),
      .checkpoint_interval = arguments.parking.checkpoint_interval,
  };
  const ensemble::RunOutcome outcome = ensemble::run_ensemble(
      world, parameters, options,
      [&parameters](const parallel::Communicator& group, std::uint64_t, const geometry::Subdomain& subdomain,
                    const dynamics::SampleControl& control) {
        return dynamics::run_sample(group, parameters, subdomain, control);
      });
  if (outcome.stopped) return stopped_resumable;
  const bool complete = outcome.failed == 0 && outcome.left == 0 && outcome.file_error.empty();
  return complete ? success : some_samples_failed;
}

}  // namespace

void add_run_command(CLI::App& app, Action& run) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = app.add_subcommand(
      "run", "Run the ensemble: rank 0 is the master, the other ranks form groups of ranks_per_sample");
  command->add_option("input", arguments->input, "input file (TOML)")->required();
  command->add_option("-o,--output", arguments->folder, "folder for the results")->required();
  command->add_flag("--resume", arguments->resume,
                    "continue the ensemble that the folder holds; samples that are done are kept");
  command->add_flag("--retry-failed", arguments->retry_failed,
                    "as --resume; samples that failed are computed again");
  command
      ->add_option("--samples", arguments->samples,
                   "compute only this range, such as 0-49: a part of the ensemble, beside others in the same "
                   "folder")
      ->check([](const std::string& text) {
        try {
          sample_range(text);
          return std::string();
        } catch (const CLI::ValidationError& error) {
          return std::string(error.what());
        }
      });
  add_parking_options(*command, arguments->parking);
  command->footer(std::string("Exit status: 0 all samples done; 1 usage or input error, nothing was written; "
                              "2 finished, but some "
                              "samples failed; 3 stopped early, continue with --resume; ") +
                  crash_help + signals_help);
  command->callback([arguments, &run] {
    run = [arguments](const parallel::Communicator& world) {
      const input::Parameters parameters = read_input(world, arguments->input);
      return end_together(world, [&] { return run_command(world, parameters, *arguments); });
    };
  });
}

}  // namespace crackle::apps
