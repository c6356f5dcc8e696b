// SPDX-License-Identifier: GPL-3.0-or-later
// crackle compare: differences between ensembles, and their significance.
#include "commands.h"
#include "crackle/analysis/comparison.h"
#include "crackle/parallel/agreement.h"

#include "ensemble_folder.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace crackle::apps {

namespace {

struct CompareOptions {
  std::vector<std::string> folders;
  double confidence = analysis::default_confidence;
  bool json = false;
};

int compare(const parallel::Communicator& world, const CompareOptions& options) {
  const std::vector<StoredEnsemble> ensembles = stored_ensembles(world, options.folders);
  parallel::agree_on_root(world, [&] {
    std::vector<analysis::Comparison> comparisons;
    for (std::size_t i = 1; i < ensembles.size(); ++i)
      comparisons.push_back(
          analysis::compare(ensembles[0].compared(), ensembles[i].compared(), options.confidence));
    const input::Sections& sections = ensembles[0].parameters.sections;
    if (options.json) {
      fmt::print("{}", analysis::to_json(comparisons, options.folders, sections));
    } else {
      for (std::size_t i = 0; i < comparisons.size(); ++i)
        fmt::print("{}{}", i == 0 ? "" : "\n",
                   analysis::to_text(comparisons[i], options.folders[0], options.folders[i + 1], sections));
    }
    std::fflush(stdout);
  });
  return success;
}

}  // namespace

void add_compare_command(CLI::App& app, Action& run) {
  auto options = std::make_shared<CompareOptions>();
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
  command->callback([options, &run] {
    run.work = [options](const parallel::Communicator& world) { return compare(world, *options); };
  });
}

}  // namespace crackle::apps
