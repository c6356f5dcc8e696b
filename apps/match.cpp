// SPDX-License-Identifier: GPL-3.0-or-later
// crackle match: experiments beside an ensemble; in Python.
#include "common/whole_number.h"
#include "python_command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <string>

namespace crackle::apps {

void add_match_command(CLI::App& app, const CommandLine& typed, Action& run) {
  struct Options {
    std::string folder, experiments, held_out, of;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("match",
                         "Hold experiments against an ensemble: the nearest samples, whether each experiment "
                         "could be one of them, "
                         "where its crack leaves theirs, and what the experiments say together; reads only");
  command->add_option("folder", options->folder, "output folder of crackle run, or the ensemble.h5 in it")
      ->required();
  command->add_option(
      "experiments", options->experiments,
      "the experiments (TOML); crackle init experiments.toml --from-ensemble FOLDER writes one to "
      "start from");
  CLI::Option* held_out = command->add_option(
      "--held-out", options->held_out,
      "instead of experiments: this number of the samples, chosen at random, against the others; "
      "\"each\": each against all others, which checks the code");
  command
      ->add_option("--of", options->of,
                   "with --held-out each: the samples of another ensemble against those of this one, whose "
                   "p-values should be uniform if both are of one distribution")
      ->needs(held_out);
  command->add_flag("--json", options->json, "print one JSON document instead, in SI units; NaN is null");
  command->footer(
      "Exit status: 0 whatever is found; 1 usage error, or an error in the experiments or the ensemble.");
  command->callback([options, typed, &run] {
    if (options->experiments.empty() == options->held_out.empty())
      throw CLI::ValidationError("match takes either an experiments file or --held-out");
    if (options->experiments.ends_with(".csv"))
      throw CLI::ValidationError(
          fmt::format("{} is a table; name it in an experiments file, as path = \"{}\" in an [[experiment]] "
                      "(crackle init experiments.toml --from-ensemble {})",
                      options->experiments, options->experiments, options->folder));
    const bool is_each = options->held_out == "each";
    if (!options->held_out.empty() && !is_each && whole_number<int>(options->held_out).value_or(0) < 1)
      throw CLI::ValidationError(
          fmt::format("--held-out: \"{}\" is neither a number of samples nor \"each\"", options->held_out));
    if (!options->of.empty() && !is_each) throw CLI::ValidationError("--of goes with --held-out each");
    run.work = [typed](const parallel::Communicator& world) { return run_in_python(world, typed); };
  });
}

}  // namespace crackle::apps
