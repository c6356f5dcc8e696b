// SPDX-License-Identifier: GPL-3.0-or-later
// crackle calibrate: the random inputs of an ensemble, given experiments; in Python.
#include "python_command.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>

namespace crackle::apps {

void add_calibrate_command(CLI::App& app, const CommandLine& typed, Action& run) {
  struct Options {
    std::string folder, experiments, output;
    bool discrepancy = false, between_specimens = false, equal_specimens = false, json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Find the random inputs of an ensemble for which it fits experiments: their posterior, what each "
      "observation contributes, predictions, and checks of all that; the ensemble is not changed");
  command->add_option("folder", options->folder, "output folder of crackle run, or the ensemble.h5 in it")
      ->required();
  command->add_option("experiments", options->experiments, "the experiments (TOML), as for crackle match")
      ->required();
  command->add_flag("--discrepancy", options->discrepancy,
                    "allow for a model that is off by an unknown amount in each quantity");
  CLI::Option* between = command->add_flag(
      "--between-specimens", options->between_specimens,
      "allow for specimens that differ by more than meshes and reading do; the default from two on");
  command
      ->add_flag("--equal-specimens", options->equal_specimens,
                 "suppose that specimens differ by no more than meshes and reading do")
      ->excludes(between);
  command->add_option(
      "-o,--output", options->output,
      "also write the posterior as [[random]] tables for an input (TOML); an existing file is "
      "not replaced");
  command->add_flag("--json", options->json, "print one JSON document instead, in SI units; NaN is null");
  command->footer(
      "Exit status: 0 whatever is found; 1 usage error, or an error in the experiments or the ensemble.");
  command->callback([options, typed, &run] {
    run.work = [typed](const parallel::Communicator& world) { return run_in_python(world, typed); };
  });
}

}  // namespace crackle::apps
