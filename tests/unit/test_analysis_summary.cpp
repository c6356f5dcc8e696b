// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/result_list.h"
#include "analysis/sample_summary.h"
#include "common/index.h"
#include "common/packing.h"
#include "common/text_table.h"
#include "cracks/branching.h"
#include "cracks/crack_line.h"
#include "cracks/crack_pattern.h"
#include "cracks/front_trajectory.h"
#include "cracks/section_crossings.h"
#include "geometry/point.h"
#include "mechanics/elasticity.h"

#include "support/job.h"
#include "support/structured_mesh.h"

#include <gmock/gmock.h>

#include <cmath>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

using namespace cracks;

using geometry::Point;

TEST(SampleSummary, SummarisesASampleWithTwoCracks) {
  const test::StructuredMesh mesh(test::notched_plate());
  dynamics::SampleResult result;
  result.outcome = dynamics::Outcome::separated;
  result.onset_force = 380.9;
  result.onset_time = 76.18;
  result.energy_error = 1e-4;
  result.energy = {{0, 0, 0, 0, 40, 0, 0}};
  result.timings = {1, 2, 3, 4, 5e6};
  result.breaks = mesh.break_between([](const Point& p) { return p[2] > 15.5  ? 2
                                                                 : p[2] > 8.5 ? 1
                                                                              : 0; },
                                     [](const Point& p) {
                                       const double advance = p[2] < 12 ? p[1] - 4 : 12 - p[1];
                                       return advance > 0 && advance < 8 ? std::floor(advance) / 200 : -1.0;
                                     });
  for (auto& broken : result.breaks) broken.load_time = result.onset_time;
  const CrackSurface surface =
      make_crack_surface(mesh.body(), mesh.realization(), result.breaks, result.onset_time);
  const input::Sections sections{.y = {6.5, 13.5}, .z = {}};
  const CrackBranches branches = find_branches(mesh.body(), surface);
  const SampleSummary row =
      summarize(mesh.body(), result, surface, crack_lines(mesh.body(), surface, branches), branches,
                section_crossings(mesh.body(), surface, branches, planes_of(sections)),
                cracks::front_trajectories(mesh.body(), surface, mechanics::rayleigh_speed({1, 0.3, 1e-6})));

  EXPECT_EQ(row.status, SampleStatus::done);
  EXPECT_EQ(row.error, "");
  EXPECT_EQ(row.onset_force, 380.9);
  EXPECT_EQ(row.onset_time, 76.18);
  EXPECT_EQ(row.outcome, static_cast<int>(dynamics::Outcome::separated));
  EXPECT_EQ(row.pattern, static_cast<int>(Pattern::two_cracks));
  EXPECT_EQ(row.overlap, 1);
  EXPECT_EQ(row.branching_points, 0);
  EXPECT_EQ(row.kinks, 0);
  EXPECT_EQ(row.breaks, static_cast<std::int64_t>(result.breaks.size()));
  EXPECT_EQ(row.crack_area, surface.area());
  EXPECT_NEAR(row.crack_speed_max, 200, 0.2);
  EXPECT_EQ(row.energy_error, 1e-4);
  // Rayleigh speed for a shear speed of 620.2 m/s and nu = 0.3.
  EXPECT_NEAR(row.crack_speed_ratio, row.crack_speed_max / (0.9274 * std::sqrt(1e6 / 2.6)), 1e-4);
  EXPECT_NEAR(row.effective_toughness, 40 / row.traced_area, 1e-12);
  EXPECT_EQ(row.wall_time, 10);
  std::printf("z = %.12g, %.12g, %.12g, %.12g\n", row.position[0], row.position[1], row.position[2],
              row.position[3]);
  EXPECT_THAT(row.position, testing::ElementsAre(testing::DoubleNear(8.5, 1e-12), testing::IsNan(),
                                                 testing::DoubleNear(15.5, 1e-12), testing::IsNan()));
  EXPECT_THAT(row.branches, testing::ElementsAre(1, 0, 1, 0));
}

TEST(SampleSummary, DividesTheCrackAreaByMaterialAndInterface) {
  const test::StructuredMesh mesh(test::notched_plate());
  const auto breaks = mesh.break_between([](const Point& p) { return p[2] > 8.5 ? 1 : 0; },
                                         [](const Point& p) { return p[1] > 4 ? p[1] : -1.0; });
  geometry::Realization realization = mesh.realization();
  const CrackSurface surface = make_crack_surface(mesh.body(), realization, breaks, 0);
  input::Parameters parameters;
  EXPECT_TRUE(crack_area_in_parts(surface, realization, parameters.materials, parameters.interfaces).empty());
  parameters.materials = {{1, 0.3, 1e-6}, {4, 0.3, 1e-6}};
  parameters.materials[0].name = "epoxy";
  parameters.materials[1].name = "glass";
  parameters.interfaces.resize(1);
  parameters.interfaces[0].between = {"epoxy", "glass"};
  EXPECT_THAT(crack_parts(parameters.materials, parameters.interfaces),
              testing::ElementsAre("epoxy", "glass", "interface epoxy-glass"));
  // Glass beyond y = 8, where the tetrahedra of the interface reach from 7 to 9.
  std::vector<double> expected(3, 0.0);
  for (const auto& tetrahedron : realization.tetrahedra) {
    const double y = geometry::centroid(realization.nodes, tetrahedron)[1];
    realization.material.push_back(y > 8 ? 1 : 0);
    realization.interface.push_back(y > 7 && y < 9 ? 1 : 0);
  }
  for (const CrackFacet& facet : surface.facets) {
    const double y =
        geometry::centroid(realization.nodes, realization.tetrahedra[index(facet.tetrahedron)])[1];
    expected[y > 7 && y < 9 ? 2 : y > 8 ? 1 : 0] += facet.area;
  }
  const auto found = crack_area_in_parts(surface, realization, parameters.materials, parameters.interfaces);
  std::printf("%.4g, %.4g, %.4g of %.4g\n", found[0], found[1], found[2], surface.area());
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_GT(found[k], 0) << k;
    EXPECT_NEAR(found[k], expected[k], 1e-12 * surface.area()) << k;
  }
  EXPECT_NEAR(found[0] + found[1] + found[2], surface.area(), 1e-12 * surface.area());

  // Waves where it broke: twice as fast in glass, with four times the modulus.
  std::vector<mechanics::IsotropicElasticity> elasticity;
  for (const auto number : realization.material) elasticity.emplace_back(parameters.materials[number]);
  const auto waves =
      rayleigh_speeds(surface, realization, {mechanics::ElasticityField(std::move(elasticity)), 1e-6});
  const double slow = mechanics::rayleigh_speed(parameters.materials[0]);
  for (const CrackFacet& facet : surface.facets) {
    const auto t = static_cast<std::int32_t>(facet.tetrahedron);
    EXPECT_NEAR(waves[t], realization.material[index(t)] == 1 ? 2 * slow : slow, 1e-12 * slow);
  }
}

/// A row in which every result has a different value.
SampleSummary some_row() {
  SampleSummary row = empty_summary(2, 2, SampleStatus::done, "a reason");
  row.note = "a note";
  int value = 0;
  const auto set = [&](auto& field) {
    field = static_cast<std::remove_reference_t<decltype(field)>>(++value);
  };
  for_each_result([&](const ResultInfo&, auto member) { set(row.*member); });
  row.breaks = 5'000'000'000;
  row.crack_area_in = {1.5, 2.5};
  for_each_position_result([&](const ResultInfo&, auto member) {
    for (auto& field : row.*member) set(field);
  });
  row.wall_time = 9.5;
  return row;
}

TEST(SampleSummary, SurvivesTheWayThroughBytes) {
  const SampleSummary row = some_row();
  const auto bytes = to_bytes(row);
  const SampleSummary back = from_bytes<SampleSummary>(bytes);
  EXPECT_EQ(to_bytes(back), bytes);
  EXPECT_EQ(back.status, row.status);
  EXPECT_EQ(back.error, row.error);
  EXPECT_EQ(back.note, row.note);
  for_each_result(
      [&](const ResultInfo& info, auto member) { EXPECT_EQ(back.*member, row.*member) << info.name; });
  for_each_position_result(
      [&](const ResultInfo& info, auto member) { EXPECT_EQ(back.*member, row.*member) << info.name; });
  EXPECT_EQ(back.wall_time, row.wall_time);
}

TEST(TextTable, HasTheDigitsThatTheScatterDeserves) {
  const auto format = [](const std::string& most, const std::vector<double>& values, double factor = 1) {
    std::vector<Observation> shown;
    for (const double value : values) shown.push_back({value});
    return fitting_format(most, shown, factor);
  };
  EXPECT_EQ(format(".6f", {166.162836, 180.4, 186.2, 201.3, 206.421156}), ".1f");
  EXPECT_EQ(format(".3f", {0.68, 0.72, 0.75, 0.77, 16.8}), ".3f") << "one far value";
  EXPECT_EQ(format(".1f", {2.1e-3, 2.3e-3, 2.4e-3}, 1e6), ".0f");
  EXPECT_EQ(format(".6f", {76.179191, 76.179192, 76.179194}), ".6f");
  EXPECT_EQ(format(".6f", {76.179191, 76.179191}), ".3f");
  EXPECT_EQ(format(".6f", {186.162836}), ".2f");
  EXPECT_EQ(format(".1e", {1, 2}), ".1e");
  EXPECT_EQ(format(".3f", {SampleSummary::none, 0}), ".3f");
}

TEST(ResultList, NamesItsCategories) {
  const char* patterns = "0 none, 1 one crack, 2 two cracks";
  EXPECT_EQ(category_name(patterns, 1), "one crack");
  EXPECT_EQ(category_name(patterns, 7), "7");
  EXPECT_EQ(n_categories(patterns), 3);
  EXPECT_EQ(n_categories(""), 0);
}

TEST(ResultList, NamesOutcomesAsTheLogDoes) {
  for_each_result([](const ResultInfo& info, auto) {
    if (std::string(info.name) != "outcome") return;
    for (int k = 0; k < n_categories(info.categories); ++k)
      EXPECT_EQ(category_name(info.categories, k), to_string(static_cast<dynamics::Outcome>(k)));
  });
}

TEST(ResultList, SaysWhichTablesShowAResult) {
  std::vector<std::string> nominal, in_sweep_table, of_computation;
  for_each_result([&](const ResultInfo& info, auto) {
    if (info.is_nominal()) nominal.emplace_back(info.name);
    if ((info.short_tables & in_sweep) != 0) in_sweep_table.emplace_back(info.name);
    if (info.about == About::computation) of_computation.emplace_back(info.name);
  });
  EXPECT_THAT(nominal, testing::ElementsAre("outcome", "pattern", "leading_notch", "hole", "hole_passage"));
  // The table of a sweep lets the first two change places.
  EXPECT_THAT(in_sweep_table,
              testing::ElementsAre("onset_force", "peak_load", "pattern", "long_bifurcations",
                                   "bifurcations_projected", "crack_area", "crack_speed_max"));
  EXPECT_THAT(of_computation, testing::ElementsAre("energy_error", "equilibrium_residual"));
}

TEST(TextTable, AlignsItsColumns) {
  EXPECT_EQ(aligned({{"", "mean", "note"}, {"load", "12", "a"}, {"work done", "3", ""}}, 1, true),
            "           mean  note\nload         12  a\nwork done     3\n");
  EXPECT_EQ(aligned({{"a", "1"}, {"long", "2"}}, " = "), "a    = 1\nlong = 2\n");
  EXPECT_EQ(with_unit("load", "N"), "load [N]");
  EXPECT_EQ(with_unit("kinks", ""), "kinks");
}

TEST(ResultList, HasARowForEachResult) {
  const std::string table = result_table();
  for_each_result([&](const ResultInfo& info, auto) {
    EXPECT_THAT(table, testing::HasSubstr(std::string("| `/samples/") + info.name + "` |"));
    EXPECT_THAT(table, testing::HasSubstr(info.meaning));
  });
  EXPECT_THAT(table, testing::HasSubstr("4 undecided"));
}

TEST(SampleSummary, RefusesDamagedBytes) {
  const auto bytes = to_bytes(some_row());
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_THROW(from_bytes<SampleSummary>(std::span(bytes).first(n)), std::runtime_error) << n;
  }
  auto longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_THROW(from_bytes<SampleSummary>(longer), std::runtime_error);
}

TEST(SampleSummary, ARowWithoutResultsHasItsShape) {
  const SampleSummary row = empty_summary(2, 3, SampleStatus::failed, "reason");
  EXPECT_EQ(row.status, SampleStatus::failed);
  EXPECT_EQ(row.error, "reason");
  EXPECT_THAT(row.position, testing::AllOf(testing::SizeIs(6), testing::Each(testing::IsNan())));
  EXPECT_THAT(row.branches, testing::AllOf(testing::SizeIs(6), testing::Each(0)));
  EXPECT_TRUE(std::isnan(row.onset_force));
  EXPECT_EQ(row.outcome, -1);
}

TEST(EnsembleWarnings, OnsetsBelowThePeakLoadAreWarnedOf) {
  std::vector<SampleSummary> rows(3);
  for (SampleSummary& row : rows) {
    row.status = SampleStatus::done;
    row.onset_force = 95;
    row.peak_load = 100;
  }
  EXPECT_TRUE(ensemble_warnings(rows).empty());
  rows[1].onset_force = 20;
  rows[2].onset_force = std::nan("");  // from rest
  const auto warnings = ensemble_warnings(rows);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], testing::HasSubstr("in 1 of 2 samples the load was more than 11 % higher"));
  EXPECT_STREQ(headline_load(rows), "peak_load");
  // The load of a held sample rose after its onset.
  rows[1].held = 1;
  EXPECT_TRUE(ensemble_warnings(rows).empty());
  EXPECT_STREQ(headline_load(rows), "onset_force");
}

TEST(LongBranches, AreThoseOfALength) {
  cracks::CrackBranches branches;
  for (const double length : {0.8e-3, 2.4e-3, 5e-3, 9e-3}) {
    cracks::BranchingPoint& point = branches.points.emplace_back();
    point.length = length;
    point.is_in_space = length < 8e-3;
  }
  auto parameters = test::job("your-own-problem.toml");  // 0.6 mm where its crack runs
  const auto body = geometry::make_body(parameters);
  EXPECT_DOUBLE_EQ(branch_length(parameters.output.branch_length, parameters.mesh, *body), 2.4e-3);
  EXPECT_EQ(branches.n_in_space(branch_length(parameters.output.branch_length, parameters.mesh, *body)), 2);
  parameters.output.branch_length = 3e-3;
  EXPECT_EQ(branches.n_in_space(branch_length(parameters.output.branch_length, parameters.mesh, *body)), 1);
  EXPECT_EQ(branches.n_in_space(), 3);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
