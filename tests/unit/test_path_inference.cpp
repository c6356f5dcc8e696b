// SPDX-License-Identifier: GPL-3.0-or-later
// Paths as wholes: how often bands hold, and the mean of cracks of which some stopped.
#include "analysis/path_inference.h"
#include "common/index.h"
#include "common/random.h"

#include "support/effort.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <functional>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double none = not_a_number;

/// Paths whose position at each section follows from the one before.
std::vector<FramedPath> made_paths(std::size_t n, std::size_t n_sections, double follows, double scatter,
                                   RandomStream& stream) {
  std::vector<FramedPath> paths(n);
  for (FramedPath& path : paths)
    for (std::size_t s = 0; s < n_sections; ++s)
      path.push_back(
          {true, s == 0 ? stream.normal() : follows * path[s - 1].value + scatter * stream.normal()});
  return paths;
}

bool holds(const std::vector<FramedPath>& paths, const std::vector<double>& half_widths) {
  for (std::size_t s = 0; s < half_widths.size(); ++s) {
    double mean = 0;
    for (const FramedPath& path : paths) mean += path[s].value / static_cast<double>(paths.size());
    if (std::abs(mean) > half_widths[s]) return false;
  }
  return true;
}

TEST(PathInference, BandsHoldAtAllSectionsTogether) {
  const int n_trials = test::repetitions(150, 300);
  for (const std::size_t n : {8, 30}) {
    int n_band = 0, n_alone = 0;
    for (std::uint64_t trial = 0; trial < index(n_trials); ++trial) {
      RandomStream stream(1, trial, "band");
      const auto paths = made_paths(n, 5, 0.8, 0.6, stream);
      n_band += holds(paths, band_half_widths(paths, {}, 0.95)) ? 1 : 0;
      std::vector<double> alone;
      for (std::size_t s = 0; s < 5; ++s) {
        std::vector<FramedPath> one;
        for (const FramedPath& path : paths) one.push_back({path[s]});
        alone.push_back(band_half_widths(one, {}, 0.95).front());
      }
      n_alone += holds(paths, alone) ? 1 : 0;
    }
    std::printf("%zu paths at five sections together: 95 %% band holds %.1f %%, intervals %.1f %%\n", n,
                100.0 * n_band / n_trials, 100.0 * n_alone / n_trials);
    EXPECT_NEAR(100.0 * n_band / n_trials, 95.5, 3.5);
    EXPECT_LT(100.0 * n_alone / n_trials, 91);
  }
}

TEST(PathInference, TheMeanOfAllIncludesCracksThatStopped) {
  const int n_trials = test::repetitions(50, 100);
  int n_plain = 0, n_all = 0, n_seen = 0, n_known = 0;
  double plain_bias = 0, bias = 0;
  for (std::uint64_t trial = 0; trial < index(n_trials); ++trial) {
    RandomStream stream(1, trial, "stop");
    auto paths = made_paths(60, 3, 1.2, 0.5, stream);
    for (FramedPath& path : paths)
      for (std::size_t s = 1; s < 3; ++s)
        if (std::isnan(path[s - 1].value) ||
            stream.uniform() > 1 / (1 + std::exp(-1.5 * path[s - 1].value - 1)))
          path[s].value = none;
    const Stopped last = stopped_cracks(paths, std::vector<int>{-1, 0, 1}, {}, 0.95)[2];
    GroupedMoments plain;
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (!std::isnan(paths[i][2].value)) plain.add(paths[i][2].value, i);
    EXPECT_EQ(last.n_all, 60);
    if (std::isnan(last.mean_of_all)) continue;
    ++n_known;
    plain_bias += plain.mean();
    bias += last.mean_of_all;
    n_plain += std::abs(plain.mean()) <= 2 * std::sqrt(plain.square_error()) ? 1 : 0;
    n_all += std::abs(last.mean_of_all) <= last.half_width_of_all ? 1 : 0;
    n_seen += last.probability <= 0.05 && last.mean_arrived > last.mean_stopped ? 1 : 0;
  }
  // Of the others, more lie beyond the arrivals than arrived.
  ASSERT_GT(n_known, 0.9 * n_trials);
  plain_bias /= n_known;
  bias /= n_known;
  const auto percent = [&](int n) { return 100.0 * n / n_known; };
  std::printf(
      "true mean 0: of those that arrive %.3f, 95 %% intervals hold %.1f %%; of all %.3f, %.1f %%; "
      "difference seen in %.1f %%\n",
      plain_bias, percent(n_plain), bias, percent(n_all), percent(n_seen));
  EXPECT_GT(plain_bias, 0.4);
  EXPECT_NEAR(bias, 0, 0.06);
  EXPECT_LT(percent(n_plain), 20);
  EXPECT_GE(percent(n_all), 90);
  EXPECT_GT(percent(n_seen), 80);
}

TEST(PathInference, StoppedCracksByHand) {
  // Those that arrive are at 1 to 5 before and at twice that here; two stop, at 6 and 8.
  std::vector<FramedPath> paths;
  for (const double before : {1.0, 2.0, 3.0, 4.0, 5.0}) paths.push_back({{true, before}, {true, 2 * before}});
  for (const double before : {6.0, 8.0}) paths.push_back({{true, before}, {true, none}});
  paths.push_back({{true, 100}, {false, none}});  // has no such section
  const auto found = stopped_cracks(paths, std::vector<int>{-1, 0}, {}, 0.95);
  EXPECT_EQ(found[0].previous, -1);
  EXPECT_EQ(found[1].n_arrived, 5);
  EXPECT_EQ(found[1].n_stopped, 2);
  EXPECT_EQ(found[1].mean_arrived, 3);
  EXPECT_EQ(found[1].mean_stopped, 7);
  EXPECT_DOUBLE_EQ(found[1].probability, 2.0 / 21) << "only at 1 and 2 would they differ as much";
  EXPECT_DOUBLE_EQ(found[1].mean_of_all, 2 * (15 + 14) / 7.0);
  EXPECT_EQ(found[1].n_all, 7);
  EXPECT_EQ(found[1].n_predicted, 2);
  EXPECT_EQ(found[1].n_beyond, 2);
  // Where more stop beyond the arrivals than arrive, the line is no mean.
  auto many = paths;
  for (int i = 0; i < 4; ++i) many.push_back({{true, 9.0 + i}, {true, none}});
  EXPECT_EQ(stopped_cracks(many, std::vector<int>{-1, 0}, {}, 0.95)[1].n_beyond, 6);
  EXPECT_TRUE(std::isnan(stopped_cracks(many, std::vector<int>{-1, 0}, {}, 0.95)[1].mean_of_all));
  // The fifth arrives and the sixth stops, of one draw.
  const std::vector<std::size_t> draws{0, 1, 2, 3, 4, 4, 5, 6};
  const Stopped of_draws = stopped_cracks(paths, std::vector<int>{-1, 0}, draws, 0.95)[1];
  EXPECT_TRUE(std::isnan(of_draws.probability));
  EXPECT_EQ(of_draws.mean_stopped, 7);
  paths.erase(paths.begin());
  EXPECT_TRUE(std::isnan(stopped_cracks(paths, std::vector<int>{-1, 0}, {}, 0.95)[1].mean_of_all))
      << "four arrivals";
}

/// At the second section there is a hole: of those that come to it one passes beside it, three go on from it,
/// one ends.
TEST(PathInference, CracksThatPassThroughAHoleHaveNotStoppedInIt) {
  std::vector<FramedPath> paths{{{true, 1}, {true, 1}, {true, 1}}, {{true, 2}, {true, none}, {true, none}}};
  for (const double before : {3.0, 4.0, 5.0}) paths.push_back({{true, before}, {true, none}, {true, before}});
  const auto found = stopped_cracks(paths, std::vector<int>{-1, 0, 1}, {}, 0.95);
  EXPECT_EQ(found[1].n_arrived, 1);
  EXPECT_EQ(found[1].n_stopped, 1);
  EXPECT_EQ(found[1].mean_stopped, 2);
  EXPECT_EQ(found[2].n_stopped, 0);
}

TEST(PathInference, CracksComeFromTheSectionThatMostReach) {
  const input::Sections sections{.y = {1, 4, 2, 3}, .z = {7}};
  const auto path = [](std::vector<double> values) {
    FramedPath found;
    for (const double value : values) found.push_back({true, value});
    return found;
  };
  // From y = 3 to both sides.
  const std::vector<FramedPath> paths{path({0, none, 0, 0, 0}), path({none, 0, none, 0, 0})};
  EXPECT_THAT(previous_sections(sections, paths), ElementsAre(2, 3, 3, -1, -1));
}

/// A plate with one notch and two sections, and a crack of each sample.
struct CracksOfSamples {
  input::Parameters parameters;
  std::vector<SampleSummary> rows;

  /// @param positions of the crack of a sample at both sections
  CracksOfSamples(int n, const std::function<std::vector<double>(int)>& positions) {
    parameters.specimen = {{0.005, 0.02, 0.1}, {crackle::testing::notch(plane::Face::y_min, 50, 5, 1)}};
    parameters.sections.y = {0.01, 0.015};
    parameters.ensemble.samples = n;
    for (int i = 0; i < n; ++i) {
      SampleSummary row = empty_summary(1, 2, SampleStatus::done);
      row.leading_start = 0;
      row.position = positions(i);
      rows.push_back(row);
    }
  }

  std::string text() const {
    return path_inference_text(make_statistics(rows, parameters), rows, parameters);
  }
};

TEST(PathInference, TheTableShowsBandsAndStoppedCracks) {
  CracksOfSamples cracks(9, [](int i) {
    return std::vector{0.05 + 1e-3 * i, i < 3 ? none : 0.06 + 1e-3 * i};
  });
  const std::string text = cracks.text();
  std::printf("%s", text.c_str());
  // Three stopped, at 51 mm on average, the others at 55.5; with them the mean is 64 mm.
  EXPECT_THAT(
      text, ::testing::ContainsRegex("\nleader +notch 0 +notch 0 +y = 15 mm +65\\.500 +1\\.963 +[0-9.]+\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex(
                        "\nleader +notch 0 +notch 0 +y = 15 mm +y = 10 mm +6 +55\\.500 +3 +51\\.000 "
                        "+0\\.[0-9]+ +64\\.000 +[0-9.]+ +3 +3\n"));
  EXPECT_THAT(text, HasSubstr("+- band"));
  // A body that came apart elsewhere, as at its supports: its crack did not stop.
  cracks.rows[0].outcome = static_cast<std::int32_t>(dynamics::Outcome::separated);
  EXPECT_THAT(cracks.text(),
              ::testing::ContainsRegex("\nleader +notch 0 +notch 0 +y = 15 mm +y = 10 mm +6 +55\\.500 +2 "
                                       "+51\\.500 "));
  for (SampleSummary& row : cracks.rows) row.position[1] = 0.06;
  EXPECT_THAT(cracks.text(), ::testing::Not(HasSubstr("stopped")));
}

TEST(PathInference, GroupsOfPathsHaveNoMean) {
  const std::string text = CracksOfSamples(20, [](int i) {
                             const double place = (i % 2 == 0 ? 0.05 : 0.07) + 1e-4 * i;
                             return std::vector{place, i < 3 ? none : place};
                           }).text();
  std::printf("%s", text.c_str());
  EXPECT_THAT(text, ::testing::ContainsRegex("\nleader +notch 0 +notch 0 +y = 10 mm +groups +- +-\n"));
  EXPECT_THAT(text,
              ::testing::ContainsRegex("\nleader +notch 0 +notch 0 +y = 15 mm +y = 10 mm +17 +[0-9.]+ +3 "
                                       "+[0-9.]+ +[0-9.]+ +- +- +3 "));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
