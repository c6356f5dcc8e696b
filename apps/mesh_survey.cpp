// SPDX-License-Identifier: GPL-3.0-or-later
// The statistics of many realizations.
#include "crackle/dynamics/stable_step.h"
#include "crackle/ensemble/estimate.h"
#include "crackle/ensemble/progress.h"
#include "crackle/ensemble/run_log.h"
#include "crackle/geometry/survey.h"
#include "crackle/io/text_file.h"
#include "crackle/stopwatch.h"
#include "mesh_tables.h"
#include "parallel_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace crackle::apps {

namespace {

using geometry::OrientationMoments;
using geometry::SurveyRow;

struct MeanAndSpread {
  double mean = 0;
  double deviation = 0;  ///< standard deviation
};

template <class Value>
std::vector<double> column(const std::vector<SurveyRow>& rows, Value value) {
  std::vector<double> values;
  for (const SurveyRow& row : rows) values.push_back(static_cast<double>(value(row)));
  return values;
}

MeanAndSpread mean_and_spread(const std::vector<double>& values) {
  MeanAndSpread result;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / n;
  for (const double value : values) result.deviation += (value - result.mean) * (value - result.mean);
  result.deviation = values.size() > 1 ? std::sqrt(result.deviation / (n - 1)) : 0;
  return result;
}

std::string spread_text(const std::vector<double>& values, double unit, int digits) {
  const geometry::Quantiles q = geometry::quantiles(values);
  return fmt::format("min {:.{}f}, median {:.{}f}, max {:.{}f}", q.smallest / unit, digits, q.median / unit,
                     digits, q.largest / unit, digits);
}

void add_orientation(TextTable& table, const OrientationMoments& base, const std::vector<SurveyRow>& rows) {
  OrientationMoments mean;
  for (const SurveyRow& row : rows)
    geometry::add_share(mean, row.orientation, 1 / static_cast<double>(rows.size()));
  if (!(base.area > 0)) {
    table.row("orientation", "the fine zone has no inside: it is nowhere two spacings below the surface");
    return;
  }
  table.row("candidate facets",
            fmt::format("{:.0f} mm^2 in the inside of the fine zone; shares by the normals' direction:",
                        mean.area * 1e6));
  const char* const axes = "xyz";
  for (std::size_t i = 0; i < 3; ++i) {
    const MeanAndSpread over =
        mean_and_spread(column(rows, [i](const SurveyRow& row) { return row.orientation.second[i][i]; }));
    table.row(fmt::format("  share along {}", axes[i]),
              fmt::format("base {:.4f}, realizations {:.4f} +- {:.4f}, isotropic {:.4f}", base.second[i][i],
                          over.mean, over.deviation, 1.0 / 3));
  }
  const auto bias = [&](const char* name, auto measure) {
    const std::vector<double> single =
        column(rows, [&](const SurveyRow& row) { return measure(row.orientation); });
    const MeanAndSpread over = mean_and_spread(single);
    table.row(name, fmt::format("base {:.4f}, realizations {:.4f} +- {:.4f}, at most {:.4f}, of their mean "
                                "tensor {:.4f}",
                                measure(base), over.mean, over.deviation,
                                *std::max_element(single.begin(), single.end()), measure(mean)));
  };
  bias("  bias, 2nd order", geometry::second_order_bias);
  bias("  bias, 4th order", geometry::fourth_order_bias);
}

void add_displacements(TextTable& table, const std::vector<SurveyRow>& rows) {
  const auto sums = [&](std::size_t kind) {
    geometry::DisplacementSums all;
    for (const SurveyRow& row : rows) all.add(row.displacement[kind]);
    return all;
  };
  const geometry::DisplacementSums interior = sums(2);
  if (interior.n[0] > 0) {
    table.row("displacements", fmt::format("{:.0f} in the interior, in amplitudes; for a uniform ball 0 and "
                                           "0.2000 in every direction:",
                                           interior.n[0]));
    table.row("  mean", fmt::format("{:.5f}, {:.5f}, {:.5f} (x, y, z; by chance +- {:.5f})", interior.mean(0),
                                    interior.mean(1), interior.mean(2), std::sqrt(0.2 / interior.n[0])));
    table.row("  covariance",
              fmt::format("{:.4f}, {:.4f}, {:.4f} (xx, yy, zz); {:.4f}, {:.4f}, {:.4f} (yz, xz, xy)",
                          interior.covariance(0, 0), interior.covariance(1, 1), interior.covariance(2, 2),
                          interior.covariance(1, 2), interior.covariance(0, 2), interior.covariance(0, 1)));
  }
  const char* const names[] = {"  along edges", "  in faces"};
  for (std::size_t kind = 2; kind-- > 0;) {
    const geometry::DisplacementSums boundary = sums(kind);
    if (*std::min_element(boundary.n.begin(), boundary.n.end()) < 1) continue;
    table.row(names[kind],
              fmt::format("mean {:.4f}, {:.4f}, {:.4f}; variance {:.4f}, {:.4f}, {:.4f}, uniform {:.4f}",
                          boundary.mean(0), boundary.mean(1), boundary.mean(2), boundary.covariance(0, 0),
                          boundary.covariance(1, 1), boundary.covariance(2, 2), kind == 0 ? 1.0 / 3 : 0.25));
  }
}

void add_times(TextTable& table, const input::Parameters& parameters, const std::vector<SurveyRow>& rows,
               double stable_step) {
  const std::vector<double> seconds = column(rows, [](const SurveyRow& row) { return row.seconds; });
  table.row("time per mesh", spread_text(seconds, 1, 3) + " s of one core, all checks included");
  table.row("  plain Delaunay",
            spread_text(column(rows, [](const SurveyRow& row) { return row.delaunay_seconds; }), 1, 3) +
                " s (CGAL, spatial sorting, the same points)");
  table.row("  ratio",
            spread_text(column(rows, [](const SurveyRow& row) { return row.seconds / row.delaunay_seconds; }),
                        1, 2));
  try {
    const auto estimate = ensemble::make_estimate(parameters, rows.front().n_tetrahedra, stable_step);
    const double sample_seconds = 3600 * estimate.core_hours / parameters.ensemble.samples;
    table.row(
        "time per sample",
        fmt::format("{:.0f} s on one core, estimated from {} force evaluations; one master feeds {:.0f} "
                    "ranks",
                    sample_seconds, estimate.force_evaluations,
                    sample_seconds / geometry::quantiles(seconds).median));
  } catch (const std::runtime_error& error) {
    table.row("time per sample", error.what());
  }
}

std::string survey_text(const input::Parameters& parameters, const geometry::MotherPoints& base,
                        double base_seconds, const OrientationMoments& base_orientation,
                        const std::vector<SurveyRow>& all, double stable_step) {
  std::vector<SurveyRow> rows;
  std::copy_if(all.begin(), all.end(), std::back_inserter(rows),
               [](const SurveyRow& row) { return row.error.empty(); });
  TextTable table;
  table.row("realizations", fmt::format("{} of seed {}: {} conform, {} failed", all.size(),
                                        parameters.ensemble.seed, rows.size(), all.size() - rows.size()));
  table.row("nodes", fmt::format("{}, made in {:.1f} s", base.size(), base_seconds));
  if (rows.empty()) return table.text();
  const auto quality = [&](auto geometry::Quantiles::*member) {
    return spread_text(column(rows, [=](const SurveyRow& row) { return row.mesh.quality.*member; }), 1, 4);
  };
  table.row("tetrahedra",
            spread_text(column(rows, [](const SurveyRow& row) { return row.n_tetrahedra; }), 1, 0));
  table.row("worst quality", fmt::format("{} (min_quality {})", quality(&geometry::Quantiles::smallest),
                                         parameters.mesh.min_quality));
  table.row("quality at 1 %", quality(&geometry::Quantiles::one_percent));
  table.row("median quality", quality(&geometry::Quantiles::median));
  const double degree = std::numbers::pi / 180;
  const auto angle = [&](auto geometry::MeshStatistics::*member) {
    return spread_text(column(rows, [=](const SurveyRow& row) { return row.mesh.*member; }), degree, 1);
  };
  table.row("smallest angle", angle(&geometry::MeshStatistics::smallest_angle) + " degrees (dihedral)");
  table.row("largest angle", angle(&geometry::MeshStatistics::largest_angle) + " degrees");
  const std::vector<double> share = column(rows, [&](const SurveyRow& row) {
    return static_cast<double>(row.report.redrawn_points) / static_cast<double>(base.size());
  });
  const std::vector<double> rounds = column(rows, [](const SurveyRow& row) { return row.report.rounds; });
  table.row("redrawn points", fmt::format("mean {:.3f} %, max {:.3f} %", 100 * mean_and_spread(share).mean,
                                          100 * *std::max_element(share.begin(), share.end())));
  table.row("rounds", fmt::format("mean {:.1f}, max {:.0f}", mean_and_spread(rounds).mean,
                                  *std::max_element(rounds.begin(), rounds.end())));
  add_displacements(table, rows);
  add_orientation(table, base_orientation, rows);
  add_times(table, parameters, rows, stable_step);
  return table.text();
}

std::string csv(const std::vector<SurveyRow>& rows) {
  std::string text =
      "sample,conforms,tetrahedra,worst_quality,quality_1_percent,median_quality,smallest_angle_rad,"
      "largest_angle_rad,redrawn_points,rounds,share_x,share_y,share_z,bias_2,bias_4,mesh_s,delaunay_s\n";
  for (const SurveyRow& row : rows)
    text += fmt::format(
        "{},{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},"
        "{:.4f},{:.4f}\n",
        row.sample, row.error.empty() ? 1 : 0, row.n_tetrahedra, row.mesh.quality.smallest,
        row.mesh.quality.one_percent, row.mesh.quality.median, row.mesh.smallest_angle,
        row.mesh.largest_angle, row.report.redrawn_points, row.report.rounds, row.orientation.second[0][0],
        row.orientation.second[1][1], row.orientation.second[2][2],
        geometry::second_order_bias(row.orientation), geometry::fourth_order_bias(row.orientation),
        row.seconds, row.delaunay_seconds);
  return text;
}

/// Fails now rather than after minutes of work.
void check_writable(const std::filesystem::path& table) {
  const std::filesystem::path folder = table.has_parent_path() ? table.parent_path() : ".";
  if (std::filesystem::is_directory(table) || ::access(folder.c_str(), W_OK) != 0)
    throw std::runtime_error(fmt::format("{}: cannot be written", table.string()));
}

}  // namespace

bool survey_meshes(const input::Parameters& parameters, std::uint64_t n_samples,
                   const std::filesystem::path& table) {
  if (!table.empty()) check_writable(table);
  const Stopwatch base_clock;
  const geometry::Body body(parameters.specimen);
  const geometry::MotherPoints base =
      geometry::make_mother_points(body, parameters.mesh, parameters.ensemble.seed);
  const double base_seconds = base_clock.seconds();
  const geometry::Survey survey(body, base, parameters.mesh, parameters.ensemble.seed);

  const Stopwatch clock;
  ensemble::RunLog log(std::cerr, terminal_width(STDERR_FILENO), [&clock] { return clock.seconds(); });
  // Meshes only: there are no cracks to keep statistics of.
  input::Parameters uncracked = parameters;
  uncracked.ensemble.samples = static_cast<int>(n_samples);
  uncracked.ensemble.stop.reset();
  uncracked.specimen.notches.clear();
  uncracked.sections.y.clear();
  ensemble::Progress progress(n_samples, 1, uncracked);
  std::vector<SurveyRow> rows;
  double stable_step = 0;  // of the first realization
  const auto look = [&](const geometry::Realization& realization) {
    if (stable_step == 0) stable_step = dynamics::stable_step(parameters, realization);
  };
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    progress.started(sample, clock.seconds());
    rows.push_back(survey.measure(sample, look));
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
  fmt::print("{}", survey_text(parameters, base, base_seconds, survey.base_orientation(), rows, stable_step));
  if (!table.empty()) {
    io::write_text_file(table, csv(rows));
    fmt::print("{:<20} {}\n", "written", table.string());
  }
  return std::all_of(rows.begin(), rows.end(), [](const SurveyRow& row) { return row.error.empty(); });
}

}  // namespace crackle::apps
