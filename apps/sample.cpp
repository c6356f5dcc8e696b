// SPDX-License-Identifier: GPL-3.0-or-later
// crackle sample: runs one sample on all ranks as one group.
#include "ensemble/run.h"

#include "parallel_command.h"

#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cstdint>
#include <iostream>
#include <memory>
#include <string>

namespace crackle::apps {

namespace {

struct SampleArguments {
  std::filesystem::path input;
  std::filesystem::path folder;
  std::uint64_t sample = 0;
  bool resume = false;
  bool retry_failed = false;
  bool overwrite = false;
  SuspendOptions suspend;
};

int sample_command(const parallel::Communicator& world, const input::Parameters& parameters,
                   const SampleArguments& arguments, const CommandLine& typed) {
  const ensemble::RunOptions options{
      .folder = arguments.folder,
      .plan = {.resume = arguments.resume || arguments.retry_failed,
               .retry_failed = arguments.retry_failed,
               .single = arguments.sample,
               .overwrite = arguments.overwrite},
      .log = &std::cout,
      .terminal_width = terminal_width(STDOUT_FILENO),
      .stop = ensemble::make_stop_request(arguments.suspend.time_limit, world.is_root()),
      .checkpoint_interval = arguments.suspend.checkpoint_interval,
      .next = {.resume = continuation(typed, "--resume"), .retry_failed = {}, .report = {}},
  };
  return exit_status(ensemble::run(world, parameters, {}, options));
}

}  // namespace

void add_sample_command(CLI::App& app, const CommandLine& typed, Action& run) {
  auto arguments = std::make_shared<SampleArguments>();
  auto* command = app.add_subcommand("sample", "Run one sample on all ranks as one group");
  command->add_option("input", arguments->input, "input file (TOML)")->required();
  add_sample_option(*command, arguments->sample)->required();
  command->add_option("-o,--output", arguments->folder, "folder for the results")->required();
  CLI::Option* resume =
      command->add_flag("--resume", arguments->resume,
                        "keep the sample if it is done; continue from its checkpoint if it was suspended");
  CLI::Option* retry_failed = command->add_flag("--retry-failed", arguments->retry_failed,
                                                "like --resume, but compute a failed sample again");
  command
      ->add_flag("--overwrite", arguments->overwrite,
                 "compute the sample of the same input from the start and replace its files; without this "
                 "or --resume, a folder that holds the sample is refused")
      ->excludes(resume)
      ->excludes(retry_failed);
  add_suspend_options(*command, arguments->suspend);
  command->footer(
      std::string("Exit status: 0 done; 1 usage or input error, nothing was written; 2 the sample "
                  "failed; 3 suspended, continue with --resume; ") +
      crash_help + signals_help);
  command->callback([arguments, typed, &run] {
    run.needs_mpi = true;
    run.work = [arguments, typed](const parallel::Communicator& world) {
      check_tasks(world, false);
      const input::Parameters parameters = read_given_input(world, arguments->input);
      refuse_sweep(parameters, arguments->input);
      return end_collectively(world, [&] { return sample_command(world, parameters, *arguments, typed); });
    };
  });
}

}  // namespace crackle::apps
