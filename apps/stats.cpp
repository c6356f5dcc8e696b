// SPDX-License-Identifier: GPL-3.0-or-later
// crackle stats: the statistics of an ensemble, recomputed from its sample files or, without those, from its
// results.
#include "analysis/bases.h"
#include "analysis/exceedance.h"
#include "analysis/path_groups.h"
#include "analysis/path_inference.h"
#include "analysis/result_list.h"
#include "analysis/sensitivity.h"
#include "analysis/statistics.h"
#include "commands.h"
#include "common/failure.h"
#include "common/regular_file.h"
#include "cracks/crack_pattern.h"
#include "ensemble/base_points.h"
#include "ensemble/results.h"
#include "ensemble/sample_plan.h"
#include "ensemble/sweep_table.h"
#include "geometry/body.h"
#include "input/reader.h"
#include "io/ensemble_file.h"
#include "io/sample_file.h"
#include "io/text_file.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "ensemble_folder.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

namespace fs = std::filesystem;

struct StatsOptions {
  std::vector<std::string> folders;
  std::string folder;                 ///< the first one
  std::vector<std::string> sections;  ///< empty: those of the ensemble
  std::vector<std::string> limits;    ///< "peak_load > 500 N"
  bool json = false;
  bool read_only = false;
  bool keep_rows = false;
  bool without_sensitivities = false;

  ensemble::MissingFiles missing() const {
    return keep_rows ? ensemble::MissingFiles::keep_rows : ensemble::MissingFiles::drop_rows;
  }
};

void print(const StatsOptions& options, const std::vector<analysis::SampleSummary>& samples,
           const analysis::Statistics& statistics, const input::Parameters& parameters,
           const analysis::Origin& origin) {
  if (options.json) {
    for (std::size_t i = 0; i < samples.size(); ++i) tell_unusable(i, samples[i]);
    fmt::print("{}",
               analysis::to_json(statistics, samples, parameters, origin, !options.without_sensitivities));
  } else {
    // First, as they may be invalid.
    std::string limits;
    const auto needed = std::span(samples).first(static_cast<std::size_t>(statistics.n_needed));
    for (const std::string& limit : options.limits)
      limits += analysis::to_text(analysis::exceedance(limit, needed, parameters.ensemble.replicates));
    fmt::print("{}", analysis::to_text(statistics, samples, parameters.sections, origin));
    fmt::print("{}", analysis::holes_text(samples, statistics.start_names));
    fmt::print("{}", analysis::path_inference_text(statistics, samples, parameters));
    if (!options.without_sensitivities)
      fmt::print("{}", analysis::to_text(analysis::sensitivities(parameters, samples), parameters));
    if (!limits.empty()) fmt::print("\n{}", limits);
    for (const auto& warning : analysis::ensemble_warnings(samples)) fmt::print("{}\n", warning);
  }
  std::fflush(stdout);
}

/// True if ensemble.h5 must not be modified: it is all that is left of an ensemble, or of an older version of
/// the program; or there never was an ensemble, only samples. Collective.
bool is_read_only(const parallel::Communicator& world, const fs::path& folder) {
  bool answer = false;
  parallel::agree_on_root(world, [&] {
    const bool has_results = is_taken(ensemble::results_file(folder));
    const bool has_only_results = has_results && !is_taken(folder / "samples");
    const bool has_only_samples = !has_results && !is_taken(folder / "input.toml");
    answer = has_only_results || has_only_samples || io::holds_older_format(folder);
  });
  return parallel::share(world, answer);
}

struct Stored {
  std::vector<analysis::SampleSummary> rows;
  analysis::Statistics statistics;
  analysis::Origin origin;
};

/// Reads an ensemble whose files must not be modified.
Stored read_stored(const fs::path& folder, const input::Parameters& parameters) {
  auto [rows, origin] = stored_samples(folder, parameters);
  analysis::Statistics statistics = analysis::make_statistics(rows, parameters);
  analysis::leave_out_surplus(statistics, 0, rows);
  return {std::move(rows), std::move(statistics), std::move(origin)};
}

/// Updates ensemble.h5 of a folder from its sample files. Collective.
ensemble::Results refresh(const parallel::Communicator& world, const StatsOptions& options,
                          const fs::path& folder, const input::Parameters& parameters) {
  geometry::MotherPoints base;
  const auto make_base = [&]() -> const geometry::MotherPoints& {
    base = ensemble::base_points(folder, parameters);
    return base;
  };
  return ensemble::write_results(world, parameters, folder, {}, make_base, options.missing());
}

int update_statistics(const parallel::Communicator& world, const StatsOptions& options) {
  const fs::path folder = options.folder;
  const input::Parameters parameters = input_of(world, folder);
  if (options.read_only || is_read_only(world, folder)) {
    parallel::agree_on_root(world, [&] {
      const Stored stored = read_stored(folder, parameters);
      print(options, stored.rows, stored.statistics, parameters, stored.origin);
    });
    return success;
  }
  const ensemble::Results results = refresh(world, options, folder, parameters);
  parallel::agree_on_root(
      world, [&] { print(options, results.rows, results.statistics, parameters, origin_of(folder)); });
  if (!results.file_error.empty()) throw parallel::AgreedError(0, results.file_error);
  return success;
}

/// Shows the statistics at sections other than those of the run. Collective.
int show_at_sections(const parallel::Communicator& world, const StatsOptions& options) {
  const input::Parameters parameters = input_of(world, options.folder);
  const input::Parameters sections = read_sections(world, parameters, options.sections);
  const ensemble::Results results = ensemble::results_at(world, parameters, sections, options.folder);
  parallel::agree_on_root(world, [&] {
    analysis::Origin origin = origin_of(fs::path(options.folder));
    const std::string note = "crossings computed again from the sample files; ensemble.h5 is not changed";
    // A separate paragraph in the text.
    origin.notes.push_back(options.json ? note : note + "\n");
    print(options, results.rows, results.statistics, sections, origin);
  });
  return success;
}

/// Statistics over several bases, one in each folder, whose files are not changed. Collective.
int show_bases(const parallel::Communicator& world, const StatsOptions& options) {
  const std::vector<StoredEnsemble> ensembles = stored_ensembles(world, options.folders);
  parallel::agree_on_root(world, [&] {
    std::vector<analysis::BaseSamples> bases;
    for (const StoredEnsemble& each : ensembles) {
      input::Parameters but_seed = each.parameters;
      but_seed.seed = 0;
      bases.push_back(
          {&each.parameters, input::sample_settings(but_seed), each.samples.rows, each.samples.origin});
    }
    const analysis::BasesStatistics found = analysis::statistics_of_bases(bases);
    const input::Sections& sections = ensembles.front().parameters.sections;
    fmt::print("{}", options.json ? analysis::to_json(found, options.folders, sections)
                                  : analysis::to_text(found, sections));
    std::fflush(stdout);
  });
  return success;
}

/// Updates the results of all cases of a sweep and its table, and prints the table. Collective.
int update_sweep(const parallel::Communicator& world, const StatsOptions& options) {
  const fs::path folder = options.folder;
  const fs::path file = ensemble::sweep_input(folder);
  const input::Parameters parameters = read_input(world, file, ensemble::copied_files(folder));
  const auto cases = read_cases(world, parameters, file, true);
  std::vector<ensemble::CaseRows> rows;
  std::string file_error;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const fs::path own = ensemble::case_folder(folder, i, cases.size());
    const input::Parameters of_case = input_of(world, own);
    rows.push_back({&cases[i], own.filename().string(), {}});
    if (options.read_only || is_read_only(world, own)) {
      parallel::agree_on_root(world, [&] { rows.back().rows = read_stored(own, of_case).rows; });
      continue;
    }
    ensemble::Results results = refresh(world, options, own, of_case);
    rows.back().rows = std::move(results.rows);
    if (!results.file_error.empty()) file_error = results.file_error;
  }
  parallel::agree_on_root(world, [&] {
    if (!options.read_only) io::write_text_file(ensemble::sweep_table(folder), ensemble::sweep_csv(rows));
    fmt::print("{}", options.json ? ensemble::sweep_json(rows) : ensemble::sweep_text(rows));
  });
  if (!file_error.empty()) throw parallel::AgreedError(0, file_error);
  return success;
}

/// True if the folder is that of a sweep. Collective.
bool is_sweep(const parallel::Communicator& world, const fs::path& folder) {
  parallel::agree_on_root(world, [&] {
    require_regular(ensemble::sweep_input(folder));
    require_regular(ensemble::sweep_table(folder));
  });
  return parallel::share(world, is_taken(ensemble::sweep_input(folder)));
}

}  // namespace

void add_stats_command(CLI::App& app, Action& run) {
  auto options = std::make_shared<StatsOptions>();
  CLI::App* command =
      app.add_subcommand("stats",
                         "Compute and print the statistics of a finished or unfinished ensemble from its "
                         "sample files, and update ensemble.h5; without sample files, use the samples in "
                         "ensemble.h5. For a sweep, print the table of all cases");
  auto columns = std::make_shared<bool>(false);
  command->add_option(
      "folder", options->folders,
      "output folder of crackle run, or the ensemble.h5 in it. Several, of inputs that differ "
      "in ensemble.seed only and have a shared base, give means and intervals for the "
      "material");
  command->add_flag("--columns", *columns, "print the table of all results of a sample (Markdown) instead");
  command->add_flag(
      "--json", options->json,
      "print one JSON document instead: the statistics, the rows of all samples and the outline of "
      "the body, or the table of a sweep, in SI units; NaN is null");
  command
      ->add_option("--limit", options->limits,
                   "also print the share of samples that meet a condition, such as \"peak_load > "
                   "500 N\" (may be given several times); --columns names the results")
      ->allow_extra_args(false)
      ->type_name("TEXT");
  CLI::Option* read_only = command->add_flag("--read-only", options->read_only, "do not change ensemble.h5");
  command->add_flag("--without-sensitivities", options->without_sensitivities,
                    "leave out the sensitivities to random inputs, which take longest");
  CLI::Option* keep_rows = command
                               ->add_flag("--keep-rows", options->keep_rows,
                                          "keep in ensemble.h5 the rows of samples whose files were moved "
                                          "away; otherwise these samples count as pending")
                               ->excludes(read_only);
  command
      ->add_option(
          "--sections", options->sections,
          "use other cross-sections, such as y=\"7 mm, 9 mm\", z=\"30 mm\", or a line given by y and z of "
          "its ends, line=\"1 mm, 2 mm; 3 mm, 4 mm\" (may be given several times): crossings are computed "
          "from the crack surfaces in the sample files; ensemble.h5 is not changed")
      ->allow_extra_args(false)
      ->type_name("TEXT")
      ->excludes(keep_rows);
  command->callback([options, columns, &run] {
    if (*columns != options->folders.empty())
      throw CLI::ValidationError("stats takes either a folder or --columns");
    if (*columns && (!options->sections.empty() || !options->limits.empty() || options->json ||
                     options->read_only || options->keep_rows || options->without_sensitivities))
      throw CLI::ValidationError("--columns takes no other option");
    if (options->folders.size() > 1 && (!options->sections.empty() || !options->limits.empty() ||
                                        options->keep_rows || options->without_sensitivities))
      throw CLI::ValidationError("several folders take no option but --json");
    if (options->json && !options->limits.empty())
      throw CLI::ValidationError("--limit cannot be combined with --json");
    if (*columns) {
      run.work = [](const parallel::Communicator& world) {
        if (world.is_root()) fmt::print("{}", analysis::result_table());
        return static_cast<int>(success);
      };
      return;
    }
    run.work = [options](const parallel::Communicator& world) {
      if (options->folders.size() > 1) return show_bases(world, *options);
      options->folder = folder_of(world, options->folders.front()).string();
      const bool is_of_one = !options->limits.empty() || !options->sections.empty();
      if (!is_of_one && is_sweep(world, options->folder)) return update_sweep(world, *options);
      return options->sections.empty() ? update_statistics(world, *options)
                                       : show_at_sections(world, *options);
    };
  });
}

}  // namespace crackle::apps
