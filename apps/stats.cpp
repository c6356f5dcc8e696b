// SPDX-License-Identifier: GPL-3.0-or-later
// crackle stats: the statistics of an ensemble, anew from its sample files or, without those, from its
// results.
#include "commands.h"
#include "crackle/analysis/crack_path.h"
#include "crackle/analysis/sample_results.h"
#include "crackle/analysis/sample_warning.h"
#include "crackle/analysis/statistics.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/results.h"
#include "crackle/ensemble/sample_plan.h"
#include "crackle/geometry/body.h"
#include "crackle/input/reader.h"
#include "crackle/io/ensemble_file.h"
#include "crackle/io/sample_file.h"
#include "crackle/parallel/agreement.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

namespace fs = std::filesystem;

/// The input that the ensemble in `folder` was started with: the run's copy of it, or what its results hold.
/// Collective.
input::Parameters input_of(const parallel::Communicator& world, const fs::path& folder) {
  const fs::path copy = folder / "input.toml";
  const fs::path results = ensemble::results_file(folder);
  // The folder holds the points too, since the input names them relative to where it was.
  const input::PointsFile points{
      .path = fs::exists(ensemble::points_copy(folder)) ? ensemble::points_copy(folder) : fs::path(),
      .digest = {}};
  int has_copy = fs::exists(copy) ? 1 : 0;
  parallel::check_mpi(MPI_Bcast(&has_copy, 1, MPI_INT, 0, world.get()), "MPI_Bcast");
  if (has_copy != 0) return read_input(world, copy, points);
  return share_input(world, results, [&] {
    if (!fs::exists(results)) {
      throw std::runtime_error(
          fmt::format("'{}' is not the folder of an ensemble: it holds neither input.toml nor ensemble.h5",
                      folder.string()));
    }
    return input::parse(io::read_ensemble(results).input_text, results, points);
  });
}

void print(const std::vector<analysis::SampleSummary>& samples, const analysis::Statistics& statistics,
           const input::Parameters& parameters) {
  fmt::print("{}", analysis::to_text(statistics, samples, parameters.sections));
  for (const auto& warning : analysis::sample_warnings(samples)) fmt::print("{}\n", warning);
  std::fflush(stdout);
}

/// Whether ensemble.h5 must stay as it is: it is all that is left of an ensemble, or of an older version of
/// the program. Collective.
bool is_read_only(const parallel::Communicator& world, const fs::path& folder) {
  int answer = 0;
  parallel::agree_on_root(world, [&] {
    const bool has_only_results =
        !fs::exists(folder / "samples") && fs::exists(ensemble::results_file(folder));
    answer = has_only_results || io::holds_older_format(folder) ? 1 : 0;
  });
  parallel::check_mpi(MPI_Bcast(&answer, 1, MPI_INT, 0, world.get()), "MPI_Bcast");
  return answer != 0;
}

/// The rows of an ensemble whose files stay as they are: those of ensemble.h5, and of sample files that it
/// does not know yet.
std::vector<analysis::SampleSummary> stored_rows(const fs::path& folder,
                                                 const input::Parameters& parameters) {
  const auto n_samples = static_cast<std::size_t>(parameters.ensemble.samples);
  auto rows = io::read_summaries(folder, parameters, 0, n_samples);
  if (!fs::exists(ensemble::results_file(folder))) return rows;
  auto samples = io::read_ensemble(ensemble::results_file(folder)).samples;
  samples.resize(std::max(samples.size(), n_samples), rows.front());
  for (std::size_t i = 0; i < n_samples; ++i) {
    if (samples[i].status == analysis::SampleStatus::pending) samples[i] = std::move(rows[i]);
  }
  return samples;
}

/// Finds the leading notch of samples whose files do not hold it yet.
/// @return what to tell about it
std::string derive_leading_notches(const input::Parameters& parameters,
                                   std::vector<analysis::SampleSummary>& rows) {
  const auto body = geometry::make_body(parameters.specimen);
  int n_open = 0;
  for (analysis::SampleSummary& row : rows) {
    if (row.status != analysis::SampleStatus::done ||
        row.pattern == static_cast<std::int32_t>(analysis::Pattern::none))
      continue;
    row.leading_notch = analysis::leading_notch(*body, parameters.sections, row.position).value_or(-1);
    if (row.leading_notch < 0) ++n_open;
  }
  return fmt::format(
      "The leading notch is not in these files, which are of an older format: it is taken from the sections "
      "that the cracks reach{}.\n",
      n_open == 0 ? "" : fmt::format(", and stays open in {}", n_open));
}

/// The statistics of an ensemble whose files stay as they are. Collective.
int show_stored(const parallel::Communicator& world, const fs::path& folder,
                const input::Parameters& parameters) {
  parallel::agree_on_root(world, [&] {
    auto samples = stored_rows(folder, parameters);
    if (io::holds_older_format(folder)) fmt::print("{}", derive_leading_notches(parameters, samples));
    const analysis::Statistics statistics = analysis::make_statistics(samples, parameters);
    analysis::leave_out_surplus(statistics, 0, samples);
    print(samples, statistics, parameters);
  });
  return success;
}

int update_statistics(const parallel::Communicator& world, const fs::path& folder) {
  const input::Parameters parameters = input_of(world, folder);
  if (is_read_only(world, folder)) return show_stored(world, folder, parameters);
  geometry::MotherPoints base;
  const ensemble::Results results =
      ensemble::write_results(world, parameters, folder, {}, [&]() -> const geometry::MotherPoints& {
        base = ensemble::base_points(folder, parameters);
        return base;
      });
  if (world.is_root()) print(results.rows, results.statistics, parameters);
  if (!results.file_error.empty()) throw parallel::AgreedError(0, results.file_error);
  return success;
}

/// The statistics at sections that the ensemble was not computed with. Collective.
int show_at_sections(const parallel::Communicator& world, const fs::path& folder,
                     const std::vector<std::string>& given) {
  const input::Parameters parameters = input_of(world, folder);
  const input::Parameters sections = read_sections(world, parameters, given);
  const ensemble::Results results = ensemble::results_at(world, parameters, sections, folder);
  if (world.is_root()) {
    fmt::print("crossings computed anew from the sample files; ensemble.h5 stays as it is\n\n");
    print(results.rows, results.statistics, sections);
  }
  return success;
}

}  // namespace

void add_stats_command(CLI::App& app, Action& run) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "stats",
      "Recompute the statistics of a finished or unfinished ensemble from its sample "
      "files, print them and bring ensemble.h5 up to date; without sample files, print those "
      "of the samples that ensemble.h5 holds");
  auto columns = std::make_shared<bool>(false);
  command->add_option("folder", *folder, "output folder of crackle run");
  command->add_flag("--columns", *columns, "print the table of all results of a sample (Markdown) instead");
  auto sections = std::make_shared<std::vector<std::string>>();
  command
      ->add_option(
          "--sections", *sections,
          "look at other cross-sections, y=\"7 mm, 9 mm\" or z=\"30 mm\" (may be given for both): their "
          "crossings follow from the crack surfaces in the sample files; ensemble.h5 stays as it is")
      ->allow_extra_args(false);
  command->callback([folder, columns, sections, &run] {
    if (*columns != folder->empty()) throw CLI::ValidationError("stats takes either a folder or --columns");
    if (*columns && !sections->empty()) throw CLI::ValidationError("--columns takes no --sections");
    if (*columns) {
      run = [](const parallel::Communicator& world) {
        if (world.is_root()) fmt::print("{}", analysis::result_table());
        return static_cast<int>(success);
      };
      return;
    }
    run = [folder, sections](const parallel::Communicator& world) {
      return sections->empty() ? update_statistics(world, *folder)
                               : show_at_sections(world, *folder, *sections);
    };
  });
}

}  // namespace crackle::apps
