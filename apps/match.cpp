// SPDX-License-Identifier: GPL-3.0-or-later
// crackle match: experiments beside an ensemble.
#include "commands.h"
#include "crackle/experiment/held_out.h"
#include "crackle/experiment/matching.h"
#include "crackle/geometry/body.h"
#include "crackle/parallel/agreement.h"

#include "ensemble_folder.h"
#include "observed_samples.h"

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <charconv>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

struct MatchOptions {
  std::string folder;
  std::string experiments;
  std::string held_out;
  std::size_t n_held_out = 0;  ///< 0: each in turn
  bool json = false;
};

constexpr const char* all_samples = "each";

void print_match(std::span<const experiment::Experiment> experiments,
                 const experiment::ObservedSamples& samples, const geometry::Body& body,
                 const input::Parameters& parameters, bool as_json) {
  const experiment::Match found = experiment::match(experiments, samples, body, parameters);
  fmt::print("{}", as_json ? experiment::to_json(found, experiments, samples) : experiment::to_text(found));
}

/// Samples held against the others.
void match_held_out(const MatchOptions& options, experiment::ObservedSamples samples,
                    const geometry::Body& body, const input::Parameters& parameters) {
  if (options.n_held_out == 0) {
    const std::size_t n = samples.samples.size();
    const auto p_values = experiment::p_values_of_samples(samples, body, [n](std::size_t n_done) {
      if (::isatty(STDERR_FILENO) != 0)
        fmt::print(stderr, "\r{} of {}{}", n_done, n, n_done == n ? "\n" : "");
    });
    fmt::print("{}", options.json ? experiment::p_values_json(samples, p_values)
                                  : experiment::p_values_text(p_values));
    return;
  }
  const auto [experiments, others] = experiment::hold_out(std::move(samples), options.n_held_out);
  print_match(experiments, others, body, parameters, options.json);
}

int match(const parallel::Communicator& world, const MatchOptions& options) {
  const auto folder = folder_of(world, options.folder);
  const input::Parameters parameters = input_of(world, folder);
  const auto body = geometry::make_composite_body(parameters);
  std::vector<experiment::Experiment> experiments;
  if (!options.experiments.empty()) experiments = read_experiments(world, options.experiments, *body);
  parallel::agree_on_root(world, [&] {
    const bool with_arms = !options.held_out.empty() || experiment::needs_arms(experiments);
    auto samples = observed_samples(folder, parameters, *body, with_arms);
    if (options.held_out.empty())
      print_match(experiments, samples, *body, parameters, options.json);
    else
      match_held_out(options, std::move(samples), *body, parameters);
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
  command->add_option(
      "experiments", options->experiments,
      "the experiments (TOML); crackle init experiments.toml --from-ensemble FOLDER writes one to "
      "start from");
  command->add_option(
      "--held-out", options->held_out,
      "instead of experiments: this number of the samples, chosen at random, against the others; "
      "\"each\": each against all others, whose p-values should be uniform");
  command->add_flag("--json", options->json, "print one JSON document instead, in SI units; NaN is null");
  command->footer(
      "Exit status: 0 whatever is found; 1 usage error, or an error in the experiments or the ensemble.");
  command->callback([options, &run] {
    if (options->experiments.empty() == options->held_out.empty())
      throw CLI::ValidationError("match takes either an experiments file or --held-out");
    if (options->experiments.ends_with(".csv"))
      throw CLI::ValidationError(
          fmt::format("{} is a table; name it in an experiments file, as path = \"{}\" in an [[experiment]] "
                      "(crackle init experiments.toml --from-ensemble {})",
                      options->experiments, options->experiments, options->folder));
    if (!options->held_out.empty() && options->held_out != all_samples) {
      const std::string& text = options->held_out;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), options->n_held_out);
      if (error != std::errc() || end != text.data() + text.size() || options->n_held_out == 0)
        throw CLI::ValidationError(
            fmt::format("--held-out: \"{}\" is neither a number of samples nor \"{}\"", text, all_samples));
    }
    run.work = [options](const parallel::Communicator& world) { return match(world, *options); };
  });
}

}  // namespace crackle::apps
