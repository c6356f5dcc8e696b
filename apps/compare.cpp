// SPDX-License-Identifier: GPL-3.0-or-later
// crackle compare: differences between ensembles, and their significance; in Python.
#include "python_command.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

namespace crackle::apps {

void add_compare_command(CLI::App& app, const CommandLine& typed, Action& run) {
  struct Options {
    std::vector<std::string> folders;
    double confidence = 0.95;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("compare",
                         "Compare ensembles with the first one: differences with confidence intervals and p "
                         "values, sample by sample where the bodies are the same; changes no files");
  command
      ->add_option("folders", options->folders, "output folders of crackle run, or the ensemble.h5 in them")
      ->required()
      ->expected(2, 100);
  command
      ->add_option("--confidence", options->confidence,
                   "level of the intervals, between 0 and 1; default: 0.95")
      ->check(CLI::Range(0.5, 0.9999));
  command->add_flag("--json", options->json, "print one JSON document instead, in SI units; NaN is null");
  command->callback([options, typed, &run] {
    run.work = [typed](const parallel::Communicator& world) { return run_in_python(world, typed); };
  });
}

}  // namespace crackle::apps
