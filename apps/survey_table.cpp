// SPDX-License-Identifier: GPL-3.0-or-later
// The table of many realizations.
#include "mesh_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
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

void add_orientation(std::vector<NamedValue>& table, const OrientationMoments& base,
                     const std::vector<SurveyRow>& rows) {
  OrientationMoments mean;
  for (const SurveyRow& row : rows)
    geometry::add_share(mean, row.orientation, 1 / static_cast<double>(rows.size()));
  if (!(base.area > 0)) {
    table.emplace_back("orientation",
                       "the fine zone has no interior: it lies nowhere two spacings below the surface");
    return;
  }
  table.emplace_back(
      "candidate facets",
      fmt::format("{:.0f} mm^2 in the interior of the fine zone; shares by direction of the normals:",
                  mean.area * 1e6));
  const char* const axes = "xyz";
  for (std::size_t i = 0; i < 3; ++i) {
    const MeanAndSpread over =
        mean_and_spread(column(rows, [i](const SurveyRow& row) { return row.orientation.second[i][i]; }));
    table.emplace_back(fmt::format("  share along {}", axes[i]),
                       fmt::format("base {:.4f}, realizations {:.4f} +- {:.4f}, isotropic {:.4f}",
                                   base.second[i][i], over.mean, over.deviation, 1.0 / 3));
  }
  const auto bias = [&](const char* name, auto measure) {
    const std::vector<double> single =
        column(rows, [&](const SurveyRow& row) { return measure(row.orientation); });
    const MeanAndSpread over = mean_and_spread(single);
    table.emplace_back(
        name, fmt::format("base {:.4f}, realizations {:.4f} +- {:.4f}, at most {:.4f}, of their mean "
                          "tensor {:.4f}",
                          measure(base), over.mean, over.deviation,
                          *std::max_element(single.begin(), single.end()), measure(mean)));
  };
  bias("  bias, 2nd order", geometry::second_order_bias);
  bias("  bias, 4th order", geometry::fourth_order_bias);
}

void add_displacements(std::vector<NamedValue>& table, const std::vector<SurveyRow>& rows) {
  const auto sums = [&](std::size_t kind) {
    geometry::DisplacementSums all;
    for (const SurveyRow& row : rows) all.add(row.displacement[kind]);
    return all;
  };
  const geometry::DisplacementSums interior = sums(2);
  if (interior.n[0] > 0) {
    table.emplace_back("displacements",
                       fmt::format("{:.0f} in the interior, in amplitudes; for a uniform ball 0 and "
                                   "0.2000 in every direction:",
                                   interior.n[0]));
    table.emplace_back("  mean",
                       fmt::format("{:.5f}, {:.5f}, {:.5f} (x, y, z; by chance +- {:.5f})", interior.mean(0),
                                   interior.mean(1), interior.mean(2), std::sqrt(0.2 / interior.n[0])));
    table.emplace_back(
        "  covariance",
        fmt::format("{:.4f}, {:.4f}, {:.4f} (xx, yy, zz); {:.4f}, {:.4f}, {:.4f} (yz, xz, xy)",
                    interior.covariance(0, 0), interior.covariance(1, 1), interior.covariance(2, 2),
                    interior.covariance(1, 2), interior.covariance(0, 2), interior.covariance(0, 1)));
  }
  const char* const names[] = {"  along edges", "  in faces"};
  for (std::size_t kind = 2; kind-- > 0;) {
    const geometry::DisplacementSums boundary = sums(kind);
    if (*std::min_element(boundary.n.begin(), boundary.n.end()) < 1) continue;
    table.emplace_back(
        names[kind],
        fmt::format("mean {:.4f}, {:.4f}, {:.4f}; variance {:.4f}, {:.4f}, {:.4f}, uniform {:.4f}",
                    boundary.mean(0), boundary.mean(1), boundary.mean(2), boundary.covariance(0, 0),
                    boundary.covariance(1, 1), boundary.covariance(2, 2), kind == 0 ? 1.0 / 3 : 0.25));
  }
}

void add_times(std::vector<NamedValue>& table, const std::vector<SurveyRow>& rows) {
  const std::vector<double> seconds = column(rows, [](const SurveyRow& row) { return row.seconds; });
  table.emplace_back("time per mesh", spread_text(seconds, 1, 3) + " s of one core, all checks included");
  table.emplace_back(
      "  plain Delaunay",
      spread_text(column(rows, [](const SurveyRow& row) { return row.delaunay_seconds; }), 1, 3) +
          " s (CGAL, spatial sorting, the same points)");
  table.emplace_back(
      "  ratio",
      spread_text(column(rows, [](const SurveyRow& row) { return row.seconds / row.delaunay_seconds; }), 1,
                  2));
}

}  // namespace

std::string survey_table(const input::Parameters& parameters, const SurveyFigures& figures) {
  std::vector<SurveyRow> rows;
  std::copy_if(figures.rows.begin(), figures.rows.end(), std::back_inserter(rows),
               [](const SurveyRow& row) { return row.error.empty(); });
  std::vector<NamedValue> table;
  table.emplace_back("realizations",
                     fmt::format("{} of seed {}: {} conform, {} failed", figures.rows.size(),
                                 parameters.ensemble.seed, rows.size(), figures.rows.size() - rows.size()));
  table.emplace_back("nodes", fmt::format("{}{}, made in {:.1f} s", figures.n_nodes,
                                          parameters.mesh.base == input::Base::own ? " in sample 0" : "",
                                          figures.base_seconds));
  if (rows.empty()) return aligned(table, "  ");
  const auto quality = [&](auto geometry::Quantiles::*member) {
    return spread_text(column(rows, [=](const SurveyRow& row) { return row.mesh.quality.*member; }), 1, 4);
  };
  table.emplace_back("tetrahedra",
                     spread_text(column(rows, [](const SurveyRow& row) { return row.n_tetrahedra; }), 1, 0));
  table.emplace_back("worst quality",
                     fmt::format("{} (min_quality {})", quality(&geometry::Quantiles::smallest),
                                 parameters.mesh.min_quality));
  table.emplace_back("quality at 1 %", quality(&geometry::Quantiles::one_percent));
  table.emplace_back("median quality", quality(&geometry::Quantiles::median));
  const double degree = std::numbers::pi / 180;
  const auto angle = [&](auto geometry::MeshStatistics::*member) {
    return spread_text(column(rows, [=](const SurveyRow& row) { return row.mesh.*member; }), degree, 1);
  };
  table.emplace_back("smallest angle",
                     angle(&geometry::MeshStatistics::smallest_angle) + " degrees (dihedral)");
  table.emplace_back("largest angle", angle(&geometry::MeshStatistics::largest_angle) + " degrees");
  const std::vector<double> share = column(rows, [&](const SurveyRow& row) {
    return static_cast<double>(row.report.redrawn_points) / static_cast<double>(row.n_nodes);
  });
  const std::vector<double> rounds = column(rows, [](const SurveyRow& row) { return row.report.rounds; });
  table.emplace_back("redrawn points",
                     fmt::format("mean {:.3f} %, max {:.3f} %", 100 * mean_and_spread(share).mean,
                                 100 * *std::max_element(share.begin(), share.end())));
  table.emplace_back("rounds", fmt::format("mean {:.1f}, max {:.0f}", mean_and_spread(rounds).mean,
                                           *std::max_element(rounds.begin(), rounds.end())));
  add_displacements(table, rows);
  add_orientation(table, figures.base_orientation, rows);
  add_times(table, rows);
  return aligned(table, "  ");
}

std::string survey_csv(std::span<const SurveyRow> rows) {
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

}  // namespace crackle::apps
