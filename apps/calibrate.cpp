// SPDX-License-Identifier: GPL-3.0-or-later
// crackle calibrate: the random inputs of an ensemble, given experiments.
#include "commands.h"
#include "crackle/experiment/calibration.h"
#include "crackle/geometry/body.h"
#include "crackle/io/text_file.h"
#include "crackle/parallel/agreement.h"

#include "ensemble_folder.h"
#include "observed_samples.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace crackle::apps {

namespace {

struct CalibrateOptions {
  std::string folder;
  std::string experiments;
  experiment::CalibrationOptions of;
  std::filesystem::path output;
  bool json = false;
};

int calibrate(const parallel::Communicator& world, const CalibrateOptions& options) {
  if (!options.output.empty()) parallel::agree_on_root(world, [&] { refuse_existing(options.output); });
  const auto folder = folder_of(world, options.folder);
  const input::Parameters parameters = input_of(world, folder);
  const auto body = geometry::make_composite_body(parameters);
  const auto experiments = read_experiments(world, options.experiments, *body);
  parallel::agree_on_root(world, [&] {
    const auto samples = observed_samples(folder, parameters, *body, experiment::needs_arms(experiments));
    const auto found = experiment::calibrate(experiments, samples, *body, parameters, options.of);
    if (!options.output.empty()) {
      refuse_existing(options.output);
      io::write_text_file(options.output, experiment::posterior_tables(found));
    }
    fmt::print("{}", options.json ? experiment::to_json(found) : experiment::to_text(found));
    std::fflush(stdout);
  });
  return success;
}

}  // namespace

void add_calibrate_command(CLI::App& app, Action& run) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Find the random inputs of an ensemble for which it fits experiments: their posterior, what each "
      "observation contributes, predictions, and checks of all that; the ensemble is not changed");
  command->add_option("folder", options->folder, "output folder of crackle run, or the ensemble.h5 in it")
      ->required();
  command->add_option("experiments", options->experiments, "the experiments (TOML), as for crackle match")
      ->required();
  command->add_flag("--discrepancy", options->of.has_discrepancy,
                    "allow for a model that is off by an unknown amount in each quantity");
  command->add_flag("--between-specimens", options->of.has_specimen_scatter,
                    "allow for specimens that differ by more than meshes and reading do; needs two or more");
  command->add_option(
      "-o,--output", options->output,
      "also write the posterior as [[random]] tables for an input (TOML); an existing file is "
      "not replaced");
  command->add_flag("--json", options->json, "print one JSON document instead, in SI units; NaN is null");
  command->footer(
      "Exit status: 0 whatever is found; 1 usage error, or an error in the experiments or the ensemble.");
  command->callback([options, &run] {
    run.work = [options](const parallel::Communicator& world) { return calibrate(world, *options); };
  });
}

}  // namespace crackle::apps
