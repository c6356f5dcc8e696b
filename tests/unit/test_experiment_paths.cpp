// SPDX-License-Identifier: GPL-3.0-or-later
// Paths as offsets, what of a sample is observed, and whole matches of made-up experiments.
#include "crackle/common/index.h"
#include "crackle/experiment/matching.h"
#include "crackle/experiment/path_frame.h"
#include "crackle/input/reader.h"
#include "experiment/sample_arms.h"

#include "support/geometry_bodies.h"
#include "support/plate_family.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace crackle::experiment {
namespace CRACKLE_TEST_FILE {

using plane::Point;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::mm;
using ::testing::Not;
using ::testing::SizeIs;

/// z = z0 + f(y) from y = 4 to 12 mm.
template <class Function>
Polyline path(const Function& f, double end = 12) {
  Polyline line;
  for (double y = 4; y <= end + 1e-9; y += 0.25) line.push_back({y * mm, (9 + f(y - 4)) * mm});
  return line;
}

TEST(PathFrame, Projections) {
  const Polyline line{{0, 0}, {3, 0}, {3, 4}};
  EXPECT_DOUBLE_EQ(length_of(line), 7);
  EXPECT_DOUBLE_EQ(project(line, {2, 1}).at, 2);
  EXPECT_DOUBLE_EQ(project(line, {2, 1}).distance, 1);
  EXPECT_DOUBLE_EQ(project(line, {4, 9}).at, 7);
  EXPECT_THAT(point_at(line, 5), ElementsAre(3, 2));
  EXPECT_THAT(extended(line, 1).front(), ElementsAre(-1, 0));
  EXPECT_THAT(extended(line, 1).back(), ElementsAre(3, 5));
}

TEST(PathFrame, OffsetsAreThoseAlongTheNormals) {
  // Parallel straight lines at 30 degrees; the middle one is the medoid.
  const double c = std::cos(std::numbers::pi / 6), s = std::sin(std::numbers::pi / 6);
  std::vector<Polyline> lines;
  for (const double shift : {-0.2, 0.0, 0.3})
    lines.push_back({{-s * shift, c * shift}, {10 * c - s * shift, 10 * s + c * shift}});
  const auto frame = path_frame(lines, std::vector<Window>{{{0, 0}, {10 * c, 10 * s}}});
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->is_along_y);
  EXPECT_THAT(offsets(*frame, lines[0]), Each(::testing::DoubleNear(-0.2, 1e-12)));
  EXPECT_THAT(offsets(*frame, lines[1]), Each(::testing::DoubleNear(0, 1e-12)));
  EXPECT_THAT(offsets(*frame, lines[2]), Each(::testing::DoubleNear(0.3, 1e-12)));
  // A line half as long arrives at half of the stations.
  const auto half = offsets(*frame, {{0, 0}, {5 * c, 5 * s}});
  EXPECT_EQ(std::ranges::count_if(half, [](double offset) { return std::isnan(offset); }), n_stations / 2);
}

TEST(PathFrame, StationsAreInTheWindow) {
  const std::vector<Polyline> lines{{{0, 0}, {10, 0}}, {{0, 1}, {10, 1}}, {{0, 2}, {10, 2}}};
  const auto seen = path_frame(lines, std::vector<Window>{{{2, 0}, {6, 0}}});
  EXPECT_DOUBLE_EQ(seen->place.front()[0], 2 + 4 * 0.5 / n_stations);
  EXPECT_DOUBLE_EQ(seen->place.back()[0], 6 - 4 * 0.5 / n_stations);
  const auto arrested = path_frame(lines, std::vector<Window>{{{2, 0}, {6, 0}, true}});
  EXPECT_DOUBLE_EQ(arrested->place.back()[0], 10 - 8 * 0.5 / n_stations);
  const auto backward = path_frame(lines, std::vector<Window>{{{6, 0}, {2, 0}, true}});
  EXPECT_DOUBLE_EQ(backward->place.front()[0], 6 * 0.5 / n_stations);
  const auto both = path_frame(lines, std::vector<Window>{{{2, 0}, {6, 0}}, {{4, 0}, {9, 0}}});
  EXPECT_GT(both->place.front()[0], 4);
  EXPECT_LT(both->place.back()[0], 6);
  EXPECT_FALSE(path_frame(lines, std::vector<Window>{{{2, 0}, {4, 0}}, {{5, 0}, {9, 0}}}));
}

TEST(PathFrame, APathBesideTheOthersMeetsNoStation) {
  const std::vector<Polyline> lines{{{0, 0}, {10, 0}}, {{0, 1}, {10, 1}}, {{0, 2}, {10, 2}}};
  const Polyline across{{4, -6}, {5, 8}}, diagonal{{0, 0}, {8, 9}};
  const Window seen{{2, 0}, {6, 0}}, astray{across.front(), across.back()};
  EXPECT_EQ(path_frame(lines, std::vector{seen, astray})->place, path_frame(lines, std::vector{seen})->place);
  const auto whole = path_frame(lines, std::vector{astray});
  EXPECT_DOUBLE_EQ(whole->place.front()[0], 10 * 0.5 / n_stations);
  const auto is_missing = [](double offset) { return std::isnan(offset); };
  EXPECT_TRUE(std::ranges::all_of(offsets(*whole, across), is_missing));
  EXPECT_TRUE(std::ranges::none_of(offsets(*whole, lines[2]), is_missing));
  EXPECT_FALSE(std::ranges::all_of(offsets(*whole, diagonal), is_missing));
  // A path longer than all others runs along them.
  EXPECT_TRUE(runs_along(whole->curve, {-20, 3}, {30, 1}));
}

TEST(PathFrame, ErrorsOfReadingHaveTheirDeviationAndCorrelation) {
  const Polyline line{{0, 0}, {40, 0}};
  double square = 0, product = 0;
  constexpr int n = 2000;
  for (int i = 0; i < n; ++i) {
    const Polyline read =
        with_reading_error(line, 0.1, 2, RandomStream(1, static_cast<std::uint64_t>(i), "test"));
    // Points are half a correlation length apart.
    ASSERT_NEAR(read[11][0] - read[10][0], 1, 1e-9);
    square += read[10][1] * read[10][1] / n;
    product += read[10][1] * read[12][1] / n;
  }
  EXPECT_NEAR(square, 0.01, 0.001);
  EXPECT_NEAR(product, 0.01 * std::exp(-1), 0.001);
  EXPECT_EQ(with_reading_error(line, 0, 2, RandomStream(1, 1, "test")), line);
}

/// Samples of a plate with one notch, whose cracks are random curves.
class MadeSamples {
public:
  MadeSamples(std::uint64_t seed, std::size_t n) : stream_(seed, 0, "made samples") {
    samples.n_planned = n;
    samples.seed = seed;
    for (std::size_t i = 0; i < n; ++i) {
      ObservedSample sample{.number = i};
      sample.summary.onset_force = 100 + 5 * stream_.normal();
      sample.summary.peak_load = sample.summary.onset_force + 1 + std::abs(stream_.normal());
      const Polyline points = crack();
      TimedLine arm{.points = points, .time = {}};
      for (std::size_t k = 0; k < points.size(); ++k) arm.time.push_back(1e-6 * static_cast<double>(k));
      sample.arms = {{arm}};
      samples.samples.push_back(std::move(sample));
    }
  }

  Polyline crack(double scale = 1, double shift = 0) {
    const double a = stream_.normal(), b = stream_.normal(), c = stream_.normal();
    return path([=](double s) {
      return shift + scale * (0.1 * a + 0.05 * b * s + 0.1 * c * std::sin(s)) + 0.02 * s * s;
    });
  }

  Experiment experiment(const std::string& name, double scale = 1, double shift = 0) {
    Experiment made{.name = name};
    made.path_error = 0.05 * mm;
    made.path_error_length = 1 * mm;
    made.lines = {with_reading_error(crack(scale, shift), made.path_error, made.path_error_length,
                                     stream_.substream(stream_.bits()))};
    made.onset_load = 100 + 5 * stream_.normal();
    made.peak_load = *made.onset_load + 1 + std::abs(stream_.normal());
    return made;
  }

  ObservedSamples samples;

private:
  RandomStream stream_;
};

geometry::ExtrudedPlate plate() {
  return testing::body({2, 16, 24}, {testing::notch(input::Face::y_min, 9, 4, 0.6)});
}

input::Parameters parameters(input::Base base = input::Base::own) {
  input::Parameters made;
  made.mesh.base = base;
  return made;
}

TEST(Match, FindsTheSampleThatIsTheExperiment) {
  MadeSamples made(4, 30);
  Experiment same = made.experiment("same");
  same.path_error = 0;
  same.lines = {made.samples.samples[17].arms[0][0].points};
  same.onset_load = made.samples.samples[17].summary.onset_force;
  same.tips = {{4e-6, same.lines[0][4]}, {10e-6, same.lines[0][10]}};
  const Match found = match(std::vector{same}, made.samples, plate(), parameters());
  ASSERT_THAT(found.experiments, SizeIs(1));
  const ExperimentMatch& one = found.experiments[0];
  ASSERT_THAT(one.by, SizeIs(5));
  for (const std::size_t k : {0u, 1u, 3u}) {
    EXPECT_EQ(one.by[k].nearest.at(0).sample, 17u) << one.by[k].name;
    EXPECT_NEAR(one.by[k].nearest[0].distance, 0, 1e-7) << one.by[k].name;
    EXPECT_GT(one.by[k].nearest[1].distance, 2 * one.by[k].nearest[0].distance) << one.by[k].name;
  }
  EXPECT_EQ(one.by[4].name, "jointly");
  EXPECT_EQ(one.p_value, one.by[4].p_value);
  EXPECT_THAT(one.path->departures, IsEmpty());
  EXPECT_FALSE(found.set);
  EXPECT_THAT(found.warnings, IsEmpty());
}

TEST(Match, TellsWhereAPathLeavesTheSamples) {
  MadeSamples made(5, 39);
  Experiment kinked = made.experiment("kinked");
  kinked.path_error = 0;
  kinked.lines = {path([](double s) { return 0.02 * s * s + (s > 5 ? 2 * (s - 5) : 0); })};
  const Match found = match(std::vector{kinked}, made.samples, plate(), parameters());
  ASSERT_TRUE(found.experiments[0].path);
  const auto& departures = found.experiments[0].path->departures;
  ASSERT_THAT(departures, SizeIs(1));
  EXPECT_GT(departures[0].from[0], 9 * mm);
  EXPECT_LT(departures[0].from[0], 10.5 * mm);
  EXPECT_GT(departures[0].to[0], 11.5 * mm);
  EXPECT_GT(departures[0].beyond, 2 * mm) << "towards +z";
  EXPECT_THAT(to_text(found), HasSubstr("kinked: its path leaves the samples' 95 % band from"));
}

TEST(Match, ACrackThatEndedIsAValue) {
  MadeSamples made(6, 39);
  Experiment arrested = made.experiment("arrested");
  arrested.path_error = 0;
  arrested.lines = {path([](double s) { return 0.02 * s * s; }, 8)};
  const auto p = [&] {
    return match(std::vector{arrested}, made.samples, plate(), parameters()).experiments[0].by[0].p_value;
  };
  EXPECT_GT(p(), 0.3) << "the picture ends there";
  arrested.is_arrested = true;
  EXPECT_DOUBLE_EQ(p(), 1.0 / 40) << "all others went on";
  for (ObservedSample& sample : made.samples.samples) {
    TimedLine& arm = sample.arms[0][0];
    if (sample.number % 2 == 0) {
      arm.points.resize(17);
      arm.time.resize(17);
    }
  }
  EXPECT_GT(p(), 0.2) << "half of the others ended there, too";
}

TEST(Match, LeavesOutAndNamesWhatHasNoValue) {
  MadeSamples made(7, 25);
  made.samples.samples[3].summary.onset_force = not_a_number;
  made.samples.samples[4].arms = {{}};
  made.samples.failed = {31};
  made.samples.undecided = {32, 33};
  const Match found = match(std::vector{made.experiment("one")}, made.samples, plate(), parameters());
  EXPECT_THAT(found.experiments[0].by[1].left_out, ElementsAre(3));
  EXPECT_EQ(found.experiments[0].by[0].n_samples, 25u) << "a sample without a crack did not arrive";
  EXPECT_EQ(found.experiments[0].by.back().n_samples, 24u);
  const std::string text = to_text(found);
  EXPECT_THAT(text, HasSubstr("1 failed (31), 2 undecided (32, 33)"));
  EXPECT_THAT(text, HasSubstr("Left out by onset load, which they lack: 1 sample (3)."));
  // From rest there is no onset: the first break takes its place.
  for (ObservedSample& sample : made.samples.samples) {
    sample.summary.first_break_load = sample.summary.peak_load;
    sample.summary.onset_force = not_a_number;
  }
  EXPECT_THAT(match(std::vector{made.experiment("two")}, made.samples, plate(), parameters())
                  .experiments[0]
                  .by[1]
                  .left_out,
              IsEmpty());
}

TEST(Match, WarnsOfSamplesThatAreNotWhatItNeeds) {
  MadeSamples made(8, 12);
  auto shared = parameters(input::Base::shared);
  shared.ensemble.replicates = 3;
  made.samples.samples[2].arms[0][0].is_turned = true;
  const Match found = match(std::vector{made.experiment("one")}, made.samples, plate(), shared);
  EXPECT_THAT(found.warnings,
              ElementsAre(HasSubstr("not valid"), HasSubstr("not exact"), HasSubstr("19 are needed"),
                          HasSubstr("in 1 of the samples another crack leads")));
  EXPECT_THAT(to_json(found, {}, made.samples), HasSubstr("not valid"));
}

TEST(Match, OfASetTellsScatterAndShift) {
  MadeSamples made(9, 40);
  std::vector<Experiment> same, wild, off;
  for (int i = 0; i < 8; ++i) {
    same.push_back(made.experiment(fmt::format("same {}", i)));
    wild.push_back(made.experiment(fmt::format("wild {}", i), 3));
    off.push_back(made.experiment(fmt::format("off {}", i), 1, -0.6));
  }
  const auto by_path = [&](const std::vector<Experiment>& experiments) {
    return match(experiments, made.samples, plate(), parameters()).set.value().by.at(0);
  };
  const SetMatchBy alike = by_path(same);
  EXPECT_GT(alike.test.p_value(), 0.05);
  EXPECT_THAT(alike.advice, HasSubstr("no evidence"));
  EXPECT_THAT(alike.advice, HasSubstr("may be chance"));
  const SetMatchBy scattered = by_path(wild);
  EXPECT_LT(scattered.test.p_value(), 0.05);
  EXPECT_THAT(scattered.advice, HasSubstr("more disturbance or a varying material"));
  EXPECT_NEAR(scattered.scatter.ratio.value, 3, 1.2);
  // Of two experiments an interval of the scatter is soon above 1.
  SetMatchBy unconfirmed = scattered;
  unconfirmed.test.energy_p_value = unconfirmed.test.depth_p_value = 0.08;
  EXPECT_THAT(advice(unconfirmed), HasSubstr("with p = 0.16 that may be chance"));
  EXPECT_THAT(advice(unconfirmed), Not(HasSubstr("more disturbance")));
  const Match all = match(off, made.samples, plate(), parameters());
  const SetMatchBy& shifted = all.set.value().by.at(0);
  EXPECT_LT(shifted.test.p_value(), 0.05);
  EXPECT_EQ(shifted.axis, "z");
  EXPECT_NEAR(shifted.scatter.shift.value, -0.6 * mm, 0.2 * mm);
  EXPECT_THAT(shifted.advice, HasSubstr("no disturbance will cure that"));
  EXPECT_EQ(all.set->by.back().name, "jointly");
  EXPECT_EQ(all.set->n_experiments, 8u);
  EXPECT_THAT(to_text(all), HasSubstr("By path: "));
}

TEST(Match, PValuesOfWholeMatchesAreUniform) {
  // Paths that are read with errors as large as half of their scatter, with loads.
  constexpr int n_trials = 80;
  std::vector<int> counts(4, 0);
  for (int trial = 0; trial < n_trials; ++trial) {
    MadeSamples made(100 + static_cast<std::uint64_t>(trial), 19);
    const Match found = match(std::vector{made.experiment("one")}, made.samples, plate(), parameters());
    ++counts.at(static_cast<std::size_t>(std::round(found.experiments[0].p_value * 20) - 1) / 5);
  }
  // Chi-square of 3 degrees of freedom at 0.001.
  double chi_square = 0;
  for (const int count : counts) chi_square += std::pow(count - n_trials / 4.0, 2) / (n_trials / 4.0);
  EXPECT_LT(chi_square, 16.3);
}

TEST(Observation, TipsArriveWhenThePathPassesThem) {
  const TimedLine arm{.points = {{0, 0}, {1, 0}, {2, 0}}, .time = {0, 1, 3}};
  EXPECT_DOUBLE_EQ(arrival_at(arm, {1.5, 0.3}), 2);
  EXPECT_DOUBLE_EQ(arrival_at(arm, {0, 1}), 0);
  EXPECT_DOUBLE_EQ(arrival_at(arm, {2.5, 0}), 3) << "within a slab and a half";
  EXPECT_TRUE(std::isnan(arrival_at(arm, {4, 0}))) << "ended before";
}

TEST(Observation, TipsAreAtTheStartWhereSlowLoadingHadBroughtThem) {
  const TimedLine arm{.points = {{0, 0}, {1, 0}, {2, 0}}, .time = {-6.4, -6.4, 3}};
  EXPECT_EQ(arrival_at(arm, {0.5, 0}), 0);
  EXPECT_DOUBLE_EQ(arrival_at(arm, {1.5, 0}), 1.5);
}

TEST(Observation, PlacesOutsideTheBodyAreRefused) {
  MadeSamples made(10, 1);
  std::vector experiments{made.experiment("good"), made.experiment("off by a thousand")};
  EXPECT_NO_THROW(check_places("x.toml", experiments, plate()));
  for (Point& p : experiments[1].lines[0]) p = 1000.0 * p;
  try {
    check_places("x.toml", experiments, plate());
    FAIL();
  } catch (const input::InputError& error) {
    EXPECT_THAT(error.messages(), ElementsAre(HasSubstr("off by a thousand")));
    EXPECT_THAT(error.messages()[0], HasSubstr("set origin, angle and mirror"));
  }
}

TEST(Observation, CracksFromHolesBeginAtTheirWalls) {
  // The crack begins at a wall of the hole far from its middle, which the middle of the body is nearer to.
  test::PlateText plate{R"(size = ["2 mm", "40 mm", "80 mm"])"};
  plate.holes = {R"(polygon = [["10 mm", "30 mm"], ["30 mm", "66 mm"], ["26 mm", "70 mm"]])"};
  const auto body = geometry::make_body(input::parse(plate.text(), "x.toml").specimen);
  const auto started = [&](std::vector<Point> path) {
    Experiment experiment;
    for (Point& p : path) p = mm * p;
    experiment.lines = {path};
    return crack_start_of(*body, experiment);
  };
  const int hole_start = 0, free_surface = 1;
  EXPECT_EQ(started({{10, 29.5}, {14, 20}, {15, 4}}), hole_start);
  EXPECT_EQ(started({{10, 29.5}, {14, 20}, {15, 0}}), hole_start) << "it ends on the free surface";
  EXPECT_EQ(started({{15, 0}, {14, 20}, {10, 29.5}}), hole_start) << "drawn from its end";
  EXPECT_EQ(started({{39, 10}, {30, 10}, {20, 9}}), free_surface);
}

TEST(ExperimentsTemplate, SaysWhereCracksStart) {
  test::PlateText plate{R"(size = ["2 mm", "40 mm", "80 mm"])"};
  plate.holes = {"center = [\"18 mm\", \"44 mm\"]\nradius = \"2.5 mm\""};
  const input::Parameters parameters = input::parse(plate.text(), "x.toml");
  const auto body = geometry::make_body(parameters.specimen);
  const std::string text = experiments_template({}, *body, parameters, "out");
  EXPECT_THAT(text, HasSubstr("# Cracks start from the walls of hole-0, from y = 15.5 mm, z = 41.5 mm to "
                              "y = 20.5 mm, z = 46.5 mm.\n"));
  EXPECT_THAT(text, Not(HasSubstr("free surface"))) << "it has no place";
}

TEST(Observation, ExperimentsFromAnotherStartAreTurned) {
  // Turned by 180 degrees the plate is the same, and each notch is at the place of the other.
  const auto body = testing::body({2, 16, 24}, {testing::notch(input::Face::y_min, 9, 4, 0.6),
                                                testing::notch(input::Face::y_max, 15, 4, 0.6)});
  MadeSamples made(11, 20);
  for (ObservedSample& sample : made.samples.samples) sample.arms.emplace_back();
  std::vector experiments{made.experiment("one"), made.experiment("other")};
  for (Point& p : experiments[1].lines[0]) p = {16 * mm - p[0], 24 * mm - p[1]};
  EXPECT_EQ(crack_start_of(body, experiments[0]), 0);
  EXPECT_EQ(crack_start_of(body, experiments[1]), 1);
  Experiment far;  // at the end of the ligament of one notch, beside the tip of the other
  far.tips = {{.time = 1e-5, .at = {15.5 * mm, 9.2 * mm}}};
  EXPECT_EQ(crack_start_of(body, far), 0);
  EXPECT_THAT(observe(experiments, made.samples, body, 0).at(0).experiments, ElementsAre(0u))
      << "the loads are not symmetric";
  made.samples.symmetries = body.symmetries();
  const Observable path = observe(experiments, made.samples, body, 0).at(0);
  ASSERT_THAT(path.experiments, SizeIs(2));
  for (const double offset : path.of_experiments.values) EXPECT_LT(std::abs(offset), 1.5 * mm);
}

TEST(Observation, SamplesAreSorted) {
  using analysis::SampleStatus;
  std::vector<analysis::SampleSummary> rows(4);
  rows[0].status = rows[3].status = SampleStatus::done;
  rows[1].status = SampleStatus::failed;
  rows[3].outcome = 4;
  const ObservedSamples sorted = sort_samples(rows, 1);
  EXPECT_THAT(sorted.samples, SizeIs(1));
  EXPECT_THAT(sorted.failed, ElementsAre(1));
  EXPECT_THAT(sorted.missing, ElementsAre(2));
  EXPECT_THAT(sorted.undecided, ElementsAre(3));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::experiment
