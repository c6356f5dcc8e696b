// SPDX-License-Identifier: GPL-3.0-or-later
// Surveys many realizations for their statistics.
#include "crackle/common/failure.h"
#include "crackle/common/stopwatch.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/progress.h"
#include "crackle/ensemble/run_log.h"
#include "crackle/geometry/survey.h"
#include "crackle/io/text_file.h"

#include "mesh_tables.h"
#include "parallel_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>

namespace crackle::apps {

namespace {

/// Fails early rather than after minutes of work.
void check_writable(const std::filesystem::path& table) {
  const std::filesystem::path folder = table.has_parent_path() ? table.parent_path() : ".";
  if (std::filesystem::is_directory(table) || ::access(folder.c_str(), W_OK) != 0)
    fail("cannot write '{}'", table.string());
}

}  // namespace

bool survey_meshes(const input::Parameters& parameters, std::uint64_t n_samples,
                   const std::filesystem::path& table) {
  const auto is_of_mesh = [](const std::string& key) {
    using enum input::Affects;
    return input::affects(key) == body || input::affects(key) == points || input::affects(key) == mesh;
  };
  for (const input::RandomInput& random : parameters.random)
    for (const std::string& key : keys_of(random))
      if (is_of_mesh(key))
        fail(
            "--survey needs the same body for all samples, but this input draws {}; use --sample for the "
            "mesh of one sample",
            key);
  if (!table.empty()) check_writable(table);
  const Stopwatch base_clock;
  const auto body = geometry::make_body(parameters);
  const geometry::MotherPoints base = ensemble::make_base_points(*body, parameters, notify);
  const double base_seconds = base_clock.seconds();
  const geometry::Survey survey(*body, base, parameters.mesh, parameters.ensemble.seed);

  const Stopwatch clock;
  ensemble::RunLog log(std::cerr, terminal_width(STDERR_FILENO), [&clock] { return clock.seconds(); });
  // Meshes only: no crack statistics at the sections are needed.
  input::Parameters uncracked = parameters;
  uncracked.ensemble.samples = static_cast<int>(n_samples);
  uncracked.ensemble.stop.reset();
  uncracked.sections = {};
  ensemble::Progress progress(n_samples, 1, uncracked);
  SurveyFigures figures{base.size(), base_seconds, survey.base_orientation(), {}, 0};
  auto& rows = figures.rows;
  const auto inspect = [&](const geometry::Realization& realization) {
    if (figures.stable_step == 0) figures.stable_step = dynamics::stable_step(parameters, realization);
  };
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    progress.started(sample, clock.seconds());
    rows.push_back(survey.measure(sample, inspect));
    const std::string& error = rows.back().error;
    if (!error.empty()) log.line(error);
    ensemble::SampleReport report;
    report.sample = sample;
    report.summary.status = error.empty() ? analysis::SampleStatus::done : analysis::SampleStatus::failed;
    report.summary.onset_force = std::nan("");
    progress.finished(report, clock.seconds());
    log.show(progress, true);
  }
  log.end_progress();
  fmt::print("{}", survey_table(parameters, figures));
  if (!table.empty()) {
    io::write_text_file(table, survey_csv(rows));
    fmt::print("{:<20} {}\n", "written", table.string());
  }
  return std::all_of(rows.begin(), rows.end(),
                     [](const geometry::SurveyRow& row) { return row.error.empty(); });
}

}  // namespace crackle::apps
