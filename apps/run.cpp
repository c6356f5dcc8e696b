// SPDX-License-Identifier: GPL-3.0-or-later
// crackle run: the ensemble.
#include "crackle/dynamics/sample_run.h"
#include "crackle/ensemble/ensemble_run.h"
#include "parallel_command.h"

#include <unistd.h>
#include <CLI/CLI.hpp>

#include <iostream>
#include <memory>

namespace crackle::apps {

namespace {

struct Arguments {
  std::filesystem::path input;
  std::filesystem::path folder;
  bool resume = false;
};

int run_command(const parallel::Communicator& world, const input::Parameters& parameters,
                const Arguments& arguments) {
  const ensemble::RunOptions options{
      .folder = arguments.folder,
      .resume = arguments.resume,
      .log = &std::cout,
      .terminal_width = terminal_width(STDOUT_FILENO),
  };
  const ensemble::RunOutcome outcome = ensemble::run_ensemble(
      world, parameters, options,
      [&parameters](const parallel::Communicator& group, std::uint64_t, const geometry::Subdomain& subdomain,
                    const dynamics::SampleLog& log) {
        return dynamics::run_sample(group, parameters, subdomain, log);
      });
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
  command->footer(
      "Exit status: 0 all samples done; 1 usage or input error, nothing was written; 2 finished, but some "
      "samples failed; 3 stopped early, continue with --resume.");
  command->callback([arguments, &run] {
    run = [arguments](const parallel::Communicator& world) {
      const input::Parameters parameters = read_input(world, arguments->input);
      return end_together(world, [&] { return run_command(world, parameters, *arguments); });
    };
  });
}

}  // namespace crackle::apps
