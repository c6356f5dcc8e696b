// SPDX-License-Identifier: GPL-3.0-or-later
// crackle sample: one realization on all ranks as one group.
#include "crackle/dynamics/sample_run.h"
#include "crackle/ensemble/single_sample.h"
#include "crackle/io/sample_file.h"
#include "parallel_command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdint>
#include <iostream>
#include <memory>
#include <string>

namespace crackle::apps {

namespace {

struct Arguments {
  std::filesystem::path input;
  std::filesystem::path folder;
  std::uint64_t sample = 0;
  bool resume = false;
  bool retry_failed = false;
  ParkingOptions parking;
};

int sample_command(const parallel::Communicator& world, const input::Parameters& parameters,
                   const Arguments& arguments) {
  const auto say = [](const std::string& line) { std::cout << line << std::endl; };
  const ensemble::SingleSampleOptions options{
      .folder = arguments.folder,
      .sample = arguments.sample,
      .resume = arguments.resume || arguments.retry_failed,
      .retry_failed = arguments.retry_failed,
      .stop = ensemble::make_stop_request(arguments.parking.time_limit),
      .checkpoint_interval = arguments.parking.checkpoint_interval,
  };
  const auto report = ensemble::run_single_sample(
      world, parameters, options,
      [&parameters](const parallel::Communicator& group, std::uint64_t, const geometry::Subdomain& subdomain,
                    const dynamics::SampleControl& control) {
        return dynamics::run_sample(group, parameters, subdomain, control);
      },
      say);
  if (world.is_root()) {
    say(describe(report));
    if (report.stored) say(io::sample_path(arguments.folder, arguments.sample).string());
  }
  if (report.parked) return stopped_resumable;
  return report.summary.status == analysis::SampleStatus::done ? success : some_samples_failed;
}

}  // namespace

void add_sample_command(CLI::App& app, Action& run) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = app.add_subcommand("sample", "Run one sample on all ranks as one group");
  command->add_option("input", arguments->input, "input file (TOML)")->required();
  add_sample_option(*command, arguments->sample)->required();
  command->add_option("-o,--output", arguments->folder, "folder for the results")->required();
  command->add_flag("--resume", arguments->resume,
                    "keep the sample if it is done, and go on from its checkpoint if it was parked");
  command->add_flag("--retry-failed", arguments->retry_failed,
                    "as --resume; a sample that failed is computed again");
  add_parking_options(*command, arguments->parking);
  command->footer(
      std::string("Exit status: 0 done; 1 usage or input error, nothing was written; 2 the sample "
                  "failed; 3 parked, continue with --resume; ") +
      crash_help + signals_help);
  command->callback([arguments, &run] {
    run = [arguments](const parallel::Communicator& world) {
      const input::Parameters parameters = read_input(world, arguments->input);
      return end_together(world, [&] { return sample_command(world, parameters, *arguments); });
    };
  });
}

}  // namespace crackle::apps
