// SPDX-License-Identifier: GPL-3.0-or-later
// crackle match: experiments beside an ensemble.
#include "commands.h"
#include "crackle/experiment/matching.h"
#include "crackle/geometry/body.h"
#include "crackle/parallel/agreement.h"

#include "ensemble_folder.h"
#include "observed_samples.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace crackle::apps {

namespace {

struct MatchOptions {
  std::string folder;
  std::string experiments;
  bool json = false;
};

int match(const parallel::Communicator& world, const MatchOptions& options) {
  const auto folder = folder_of(world, options.folder);
  const input::Parameters parameters = input_of(world, folder);
  const auto body = geometry::make_body(parameters.specimen);
  const auto experiments = read_experiments(world, options.experiments, *body);
  parallel::agree_on_root(world, [&] {
    const auto samples = observed_samples(folder, parameters, *body, experiment::needs_arms(experiments));
    const experiment::Match found = experiment::match(experiments, samples, *body, parameters);
    fmt::print("{}",
               options.json ? experiment::to_json(found, experiments, samples) : experiment::to_text(found));
    std::fflush(stdout);
  });
  return success;
}

}  // namespace

void add_match_command(CLI::App& app, Action& run) {
  auto options = std::make_shared<MatchOptions>();
  CLI::App* command =
      app.add_subcommand("match",
                         "Hold experiments against an ensemble: the nearest samples, whether each experiment "
                         "could be one of them, "
                         "where its crack leaves theirs, and what the experiments say together; reads only");
  command->add_option("folder", options->folder, "output folder of crackle run, or the ensemble.h5 in it")
      ->required();
  command
      ->add_option(
          "experiments", options->experiments,
          "the experiments (TOML); crackle init experiments.toml --from-ensemble FOLDER writes one to "
          "start from")
      ->required();
  command->add_flag("--json", options->json, "print one JSON document instead, in SI units; NaN is null");
  command->footer(
      "Exit status: 0 whatever is found; 1 usage error, or an error in the experiments or the ensemble.");
  command->callback([options, &run] {
    run = [options](const parallel::Communicator& world) { return match(world, *options); };
  });
}

}  // namespace crackle::apps
