// SPDX-License-Identifier: GPL-3.0-or-later
// Statistics of leading and following cracks, in the frame of the leading one.
#include "analysis/leader_frame.h"
#include "analysis/running_statistics.h"
#include "common/random.h"
#include "cracks/crack_pattern.h"

#include "support/geometry_bodies.h"

#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

using namespace cracks;

using crackle::testing::body;
using crackle::testing::mm;
using crackle::testing::notch;
using plane::Face;
using ::testing::ElementsAre;
using ::testing::IsNan;

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// The paper's plate: a half-turn maps one notch onto the other.
const plane::Specimen specimen{{5 * mm, 24.5 * mm, 140 * mm},
                               {notch(Face::y_min, 67.5, 5.5, 0.6), notch(Face::y_max, 72.5, 5.5, 0.6)}};

geometry::Body plate() {
  return *geometry::make_body(specimen);
}

/// 7 and 17.5 mm are images of each other, 12.25 mm is its own, 9 mm has none.
const input::Sections sections{.y = {7 * mm, 9 * mm, 12.25 * mm, 17.5 * mm}, .z = {}};

input::Parameters parameters(int samples) {
  input::Parameters p;
  p.ensemble.samples = samples;
  p.specimen = specimen;
  p.sections = sections;
  return p;
}

/// @param z_mm of both notches at all sections
SampleSummary row(int leading, std::vector<double> z_mm, Pattern pattern = Pattern::two_cracks) {
  SampleSummary summary = empty_summary(2, 4, SampleStatus::done);
  for (double& z : z_mm) z *= mm;
  summary.position = std::move(z_mm);
  summary.leading_start = leading;
  summary.pattern = static_cast<std::int32_t>(pattern);
  return summary;
}

/// The same sample rotated by 180 degrees.
SampleSummary turned(const SampleSummary& sample) {
  SampleSummary summary = sample;
  summary.leading_start = 1 - sample.leading_start;
  summary.position.assign(8, none);
  const std::array<std::size_t, 4> image{3, 4, 2, 0};  // 4: none
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t s = 0; s < 4; ++s)
      if (image[s] < 4) summary.position[(1 - k) * 4 + image[s]] = 140 * mm - sample.position[k * 4 + s];
  return summary;
}

std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> result;
  for (const double value : values) result.push_back(std::bit_cast<std::uint64_t>(value));
  return result;
}

LeaderFrame frame_of(const geometry::Body& body, const input::Sections& at) {
  return {body, body.symmetries(), at};
}

TEST(LeaderFrame, AHalfTurnMapsTheNotchesOfThePlateOnEachOther) {
  const LeaderFrame frame = frame_of(plate(), sections);
  EXPECT_THAT(frame.reference(), ElementsAre(0, 0));
  const auto own = frame.source(0, 1, 1).value();
  EXPECT_EQ(own.start, 1);
  EXPECT_EQ(own.section, 1);
  EXPECT_FALSE(own.extent);
  const auto image = frame.source(1, 0, 0).value();
  EXPECT_EQ(image.start, 1);
  EXPECT_EQ(image.section, 3);
  EXPECT_EQ(image.extent, 140 * mm);
  EXPECT_EQ(frame.source(1, 1, 2)->start, 0);
  EXPECT_EQ(frame.source(1, 1, 2)->section, 2);
  EXPECT_FALSE(frame.source(1, 0, 1)) << "no section at 15.5 mm";
}

TEST(LeaderFrame, ReflectionsMapTheNotchesOfOtherBodies) {
  // Opposite each other: reflected in y only, z unchanged.
  const auto opposite = body({3, 16, 24}, {notch(Face::y_max, 9, 4, 0.6), notch(Face::y_min, 9, 4, 0.6)});
  const input::Sections y{.y = {4 * mm, 12 * mm}, .z = {}};
  const LeaderFrame in_y = frame_of(opposite, y);
  EXPECT_THAT(in_y.reference(), ElementsAre(0, 0));
  EXPECT_EQ(in_y.source(1, 0, 0)->section, 1);
  EXPECT_FALSE(in_y.source(1, 0, 0)->extent);
  // In one face: reflected in z only, sections unchanged, even without an image.
  const auto beside = body({3, 16, 24}, {notch(Face::y_min, 7, 4, 0.6), notch(Face::y_min, 17, 4, 0.6)});
  const LeaderFrame in_z = frame_of(beside, {.y = {5 * mm}, .z = {}});
  EXPECT_THAT(in_z.reference(), ElementsAre(0, 0));
  EXPECT_EQ(in_z.source(1, 0, 0)->section, 0);
  EXPECT_EQ(in_z.source(1, 0, 0)->extent, 24 * mm);
  // Two pairs and one alone.
  const auto five = body({3, 16, 24}, {notch(Face::y_min, 12, 4, 0.6), notch(Face::y_min, 7, 2, 0.6),
                                       notch(Face::y_max, 3, 2, 0.6), notch(Face::y_max, 21, 2, 0.6),
                                       notch(Face::y_min, 17, 2, 0.6)});
  EXPECT_THAT(frame_of(five, y).reference(), ElementsAre(0, 1, 2, 2, 1));
}

TEST(LeaderFrame, LinesAreTurnedIntoTheirImages) {
  // The half-turn maps (5, 60) to (19.5, 80) mm.
  const input::SectionLine own{{5 * mm, 60 * mm}, {19.5 * mm, 80 * mm}};  // its own image, reversed
  const input::SectionLine one{{8 * mm, 50 * mm}, {9 * mm, 70 * mm}};
  const input::SectionLine image{{16.5 * mm, 90 * mm}, {15.5 * mm, 70 * mm}};
  const input::SectionLine lonely{{8 * mm, 50 * mm}, {9 * mm, 71 * mm}};
  const LeaderFrame frame =
      frame_of(plate(), {.y = {12.25 * mm}, .z = {}, .lines = {own, one, image, lonely}});
  EXPECT_EQ(frame.n_sections(), 5);
  EXPECT_EQ(frame.source(1, 0, 0)->section, 0);
  EXPECT_EQ(frame.source(1, 0, 1)->section, 1);
  EXPECT_NEAR(frame.source(1, 0, 1)->extent.value(), std::hypot(14.5, 20.0) * mm, 1e-12);
  EXPECT_EQ(frame.source(1, 0, 2)->section, 3);
  EXPECT_EQ(frame.source(1, 0, 3)->section, 2);
  EXPECT_FALSE(frame.source(1, 0, 3)->extent);
  EXPECT_FALSE(frame.source(1, 0, 4)) << "no line there";
  for (int section = 0; section < 5; ++section) {
    EXPECT_EQ(frame.source(0, 1, section)->section, section) << "not turned";
    EXPECT_FALSE(frame.source(0, 1, section)->extent);
  }
}

TEST(LeaderFrame, SectionsAcrossZAreTurnedLikeThoseAcrossY) {
  // A half-turn of notches in z-faces: z sections go to length - z, positions y to width - y.
  const auto upright = body({5, 140, 24}, {notch(Face::z_min, 60, 5, 0.6), notch(Face::z_max, 80, 5, 0.6)});
  const input::Sections both{.y = {70 * mm, 30 * mm}, .z = {8 * mm, 10 * mm, 16 * mm}};
  const LeaderFrame frame = frame_of(upright, both);
  EXPECT_THAT(frame.reference(), ElementsAre(0, 0));
  EXPECT_EQ(frame.n_sections(), 5);
  EXPECT_EQ(frame.source(1, 0, 0)->section, 0) << "y = 70 mm is its own image";
  EXPECT_EQ(frame.source(1, 0, 0)->extent, 24 * mm);
  EXPECT_FALSE(frame.source(1, 0, 1)) << "no section at y = 110 mm";
  EXPECT_EQ(frame.source(1, 0, 2)->start, 1);
  EXPECT_EQ(frame.source(1, 0, 2)->section, 4);
  EXPECT_EQ(frame.source(1, 0, 2)->extent, 140 * mm);
  EXPECT_FALSE(frame.source(1, 0, 3)) << "no section at z = 14 mm";
  EXPECT_FALSE(frame.source(0, 0, 3)->extent);
  // In one face: reflected in y only, z sections unchanged.
  const auto beside = body({5, 140, 24}, {notch(Face::z_min, 60, 5, 0.6), notch(Face::z_min, 80, 5, 0.6)});
  const LeaderFrame in_y = frame_of(beside, {.y = {}, .z = {10 * mm}});
  EXPECT_EQ(in_y.source(1, 0, 0)->section, 0);
  EXPECT_EQ(in_y.source(1, 0, 0)->extent, 140 * mm);
}

TEST(LeaderFrame, WithoutSymmetryEachNotchIsAClassOfItsOwn) {
  const auto other_depth =
      body({5, 24.5, 140}, {notch(Face::y_min, 67.5, 5.5, 0.6), notch(Face::y_max, 72.5, 5.4, 0.6)});
  for (const LeaderFrame& frame : {frame_of(other_depth, sections), LeaderFrame(2, 4)}) {
    EXPECT_THAT(frame.reference(), ElementsAre(0, 1));
    EXPECT_EQ(frame.source(1, 1, 1)->start, 1);
    EXPECT_EQ(frame.source(1, 1, 1)->section, 1);
  }
}

/// The plate of `specimen` under conditions.
input::Parameters loaded(const std::vector<input::Boundary>& conditions, input::Start start) {
  input::Parameters p = parameters(1);
  p.boundaries = conditions;
  p.time.start = start;
  return p;
}

input::Boundary held(const char* face, std::array<bool, 3> components = {true, true, true}) {
  input::Boundary condition;
  condition.on = face;
  condition.components = components;
  return condition;
}

input::Boundary pulled(const char* face, Vector value,
                       input::BoundaryKind kind = input::BoundaryKind::force) {
  input::Boundary condition;
  condition.on = face;
  condition.kind = kind;
  condition.value = condition.rate = value;
  condition.components = {false, value[1] != 0, value[2] != 0};
  return condition;
}

/// A half-turn maps one notch onto the other, so the loads decide.
TEST(LeaderFrame, IsThatOfTheLoadsToo) {
  using enum input::BoundaryKind;
  using enum input::Start;
  input::Boundary offset = pulled("z-max", {0, 0, 10});
  offset.region[1] = {0, 12 * mm};
  input::Boundary late = pulled("z-min", {0, 0, -10});
  late.history = {{0, 0}, {1, 1}};
  const input::Boundary side = held("y-min", {false, true, false}), end = held("z-min");
  const input::Boundary pull = pulled("z-max", {0, 0, 10}), other = pulled("z-min", {0, 0, -10});
  const input::Boundary grip = pulled("z-max", {0, 0, 1 * mm}, displacement);
  struct Case {
    const char* name;
    std::vector<input::Boundary> conditions;
    bool is_symmetric, is_symmetric_from_rest;
  };
  const std::vector<Case> cases{
      {"nothing", {}, true, true},
      {"the paper's", {end, pull}, true, false},
      {"forces at both ends", {other, pull}, true, true},
      {"another force", {pulled("z-min", {0, 0, -9}), pull}, false, false},
      {"both push the same way", {pulled("z-min", {0, 0, 10}), pull}, false, false},
      {"one force later", {late, pull}, false, false},
      {"a cantilever", {end, pulled("z-max", {0, 10, 0})}, false, false},
      {"half an end", {end, offset}, false, false},
      {"a traction", {end, pulled("z-max", {0, 0, 1e6}, traction)}, true, false},
      {"grips", {end, grip}, true, false},
      {"grips that move apart", {pulled("z-min", {0, 0, -1 * mm}, displacement), grip}, true, true},
      {"an impact", {pulled("z-min", {0, 0, 10}, velocity)}, false, false},
      {"a held side", {end, pull, side}, false, false},
      {"both sides held", {end, pull, side, held("y-max", {false, true, false})}, true, false},
      {"pressure on a side", {end, pulled("y-min", {1e6, 0, 0}, pressure)}, false, false},
      {"pressure on both",
       {pulled("y-min", {1e6, 0, 0}, pressure), pulled("y-max", {1e6, 0, 0}, pressure)},
       true,
       true},
      {"one end absorbs", {other, pull, pulled("z-max", {}, absorbing)}, false, false}};
  for (const Case& one : cases) {
    for (const auto& [start, is_symmetric] :
         {std::pair{quasi_static, one.is_symmetric}, std::pair{rest, one.is_symmetric_from_rest}}) {
      const auto parameters = loaded(one.conditions, start);
      const LeaderFrame frame(parameters, parameters.sections);
      EXPECT_EQ(frame.reference()[1], is_symmetric ? 0 : 1)
          << one.name << (start == rest ? " from rest" : "");
      EXPECT_EQ(frame.starts(0)[0], 0) << one.name;
    }
  }
}

/// Factors, body forces and initial velocities decide, too.
TEST(LeaderFrame, IsThatOfLoadsThatVary) {
  using enum input::LoadKind;
  const auto shaped = [](const char* face, double sign, input::FactorTable table) {
    input::Boundary load = pulled(face, {0, 0, sign * 1e6}, input::BoundaryKind::traction);
    load.factor = {1, std::move(table)};
    return load;
  };
  const auto on_all = [](input::LoadKind kind, Vector value) {
    input::BodyLoad load;
    load.kind = kind;
    load.value = value;
    return load;
  };
  const Vector size = parameters(1).specimen.size;
  const auto turning = [&](const Vector& point) {
    input::BodyLoad load;
    load.kind = angular_velocity;
    load.angular_velocity = 10;
    load.axis = {1, 0, 0};
    load.point = point;
    return load;
  };
  input::BodyLoad stretching;
  stretching.kind = velocity_gradient;
  stretching.gradient[2] = {0, 0, 100};
  stretching.point = 0.5 * size;
  input::BodyLoad shifted = stretching;
  shifted.point[2] = 0;
  const input::FactorTable rising{{0, 0}, {size[1], 1}}, falling{{0, 1}, {size[1], 0}},
      hat{{0.25 * size[1], 0}, {0.5 * size[1], 1}, {0.75 * size[1], 0}};
  struct Case {
    const char* name;
    std::vector<input::Boundary> conditions;
    std::vector<input::BodyLoad> loads;
    bool is_symmetric;
  };
  for (const Case& one : std::vector<Case>{
           {"the same at both ends", {shaped("z-min", -1, rising), shaped("z-max", 1, rising)}, {}, false},
           {"turned", {shaped("z-min", -1, falling), shaped("z-max", 1, rising)}, {}, true},
           {"a hat", {shaped("z-min", -1, hat), shaped("z-max", 1, hat)}, {}, true},
           {"a hat at one end",
            {pulled("z-min", {0, 0, -1e6}, input::BoundaryKind::traction), shaped("z-max", 1, hat)},
            {},
            false},
           {"falls along", {}, {on_all(acceleration, {0, 0, -10})}, false},
           {"falls across", {}, {on_all(acceleration, {1, 0, 0})}, true},
           {"turns about its middle", {}, {turning(0.5 * size)}, true},
           {"turns about its end", {}, {turning({0, 0, 0})}, false},
           {"stretches from its middle", {}, {stretching}, true},
           {"stretches from its end", {}, {shifted}, false},
           {"moves back", {}, {shifted, on_all(velocity, {0, 0, -50 * size[2]})}, true}}) {
    input::Parameters p = loaded(one.conditions, input::Start::rest);
    p.loads = one.loads;
    EXPECT_EQ(LeaderFrame(p, p.sections).reference()[1], one.is_symmetric ? 0 : 1) << one.name;
  }
  // Held at one end, a growing weight is not an image of its support's reaction.
  input::Parameters hangs = loaded({held("z-min"), pulled("z-max", {0, 0, 10})}, input::Start::quasi_static);
  EXPECT_EQ(LeaderFrame(hangs, hangs.sections).reference()[1], 0);
  hangs.loads = {on_all(body_force, {1, 0, 0})};
  EXPECT_EQ(LeaderFrame(hangs, hangs.sections).reference()[1], 1);
}

TEST(LeaderStatistics, TurnedSamplesCountAsTheirImage) {
  const std::vector<SampleSummary> samples{
      row(0, {67, 66.8, 66.5, 66.9, none, none, none, 73}),
      turned(row(0, {67.2, none, 66.7, none, none, none, 69, 73.2})),
      row(-1, {68, none, none, none, none, none, none, none}),
  };
  const Statistics s = make_statistics(samples, parameters(3));
  EXPECT_THAT(s.reference_start, ElementsAre(0, 0));
  EXPECT_THAT(s.leader.leading_start, ElementsAre(0));
  EXPECT_THAT(s.leader.start, ElementsAre(0));
  EXPECT_THAT(s.leader.reached, ElementsAre(2, 1, 2, 1));
  EXPECT_THAT(s.leader.counted, ElementsAre(2, 1, 2, 2)) << "at 9 mm only samples that are not turned";
  EXPECT_NEAR(s.leader.z_mean[0], 67.1 * mm, 1e-12);
  EXPECT_EQ(s.leader.z_mean[1], 66.8 * mm);
  EXPECT_NEAR(s.leader.z_mean[2], 66.6 * mm, 1e-12);
  EXPECT_NEAR(s.leader.z_std[0], 0.2 * mm / std::sqrt(2.0), 1e-12);
  // Student's t for one degree of freedom and 95 % is 12.7062047364.
  EXPECT_NEAR(s.leader.z_half_width[0], 12.7062047364 * 0.1 * mm, 1e-10);
  EXPECT_EQ(s.leader.z_quantile.size(), 20U);
  EXPECT_NEAR(s.leader.running_mean[4], 67.1 * mm, 1e-12);
  EXPECT_EQ(s.leader.running_mean[8], s.leader.running_mean[4]) << "where nothing leads nothing is added";
  EXPECT_THAT(s.follower.leading_start, ElementsAre(0));
  EXPECT_THAT(s.follower.start, ElementsAre(1));
  EXPECT_THAT(s.follower.reached, ElementsAre(0, 0, 1, 2));
  EXPECT_NEAR(s.follower.z_mean[3], 73.1 * mm, 1e-12);
  // All cracks of a notch, leading or not.
  EXPECT_THAT(s.reached, ElementsAre(3, 1, 2, 1, 0, 0, 1, 2));
}

TEST(LeaderStatistics, PositionsAtSectionsAcrossZAreTurnedInY) {
  input::Parameters p;
  p.ensemble.samples = 2;
  p.specimen = {{5 * mm, 140 * mm, 24 * mm}, specimen.notches};
  p.specimen.notches[0].face = Face::z_min;
  p.specimen.notches[1].face = Face::z_max;
  p.sections = {.y = {}, .z = {8 * mm, 16 * mm}};
  SampleSummary own = empty_summary(2, 2, SampleStatus::done), other = own;
  own.leading_start = 0;
  own.position = {67 * mm, 68 * mm, none, 73 * mm};
  other.leading_start = 1;
  other.position = {none, none, 71 * mm, 72 * mm};
  const Statistics s = make_statistics(std::vector{own, other}, p);
  EXPECT_THAT(s.leader.reached, ElementsAre(2, 2));
  EXPECT_NEAR(s.leader.z_mean[0], 67.5 * mm, 1e-12) << "72 mm is 68 mm from the other end";
  EXPECT_NEAR(s.leader.z_mean[1], 68.5 * mm, 1e-12);
  EXPECT_THAT(s.follower.reached, ElementsAre(0, 1));
}

TEST(LeaderStatistics, WithoutSymmetryThereAreRowsForEachLeadingNotch) {
  const std::vector<SampleSummary> samples{row(0, {67, 66, 65, 64, none, none, none, 73}),
                                           row(1, {68, none, none, none, 70, 71, 72, 73})};
  const Statistics s = make_statistics(samples, 2, 4);
  EXPECT_THAT(s.leader.leading_start, ElementsAre(0, 1));
  EXPECT_THAT(s.leader.start, ElementsAre(0, 1));
  EXPECT_THAT(s.leader.reached, ElementsAre(1, 1, 1, 1, 1, 1, 1, 1));
  EXPECT_EQ(s.leader.z_mean[7], 73 * mm);
  EXPECT_THAT(s.follower.leading_start, ElementsAre(0, 1));
  EXPECT_THAT(s.follower.start, ElementsAre(1, 0));
  EXPECT_THAT(s.follower.reached, ElementsAre(0, 0, 0, 1, 1, 0, 0, 0));
  EXPECT_EQ(s.follower.z_mean[4], 68 * mm);
}

TEST(LeaderStatistics, PatternsHaveTheirOwnMeanPath) {
  const std::vector<SampleSummary> samples{
      row(0, {67, 67, 67, 67, none, none, none, none}, Pattern::one_crack),
      turned(row(0, {66, 66, 66, 66, none, none, none, none}, Pattern::two_cracks)),
      row(0, {65, 65, 65, 65, none, none, none, none}, Pattern::other)};
  const Statistics s = make_statistics(samples, parameters(3));
  EXPECT_EQ(s.leader_one_crack.z_mean[2], 67 * mm);
  EXPECT_THAT(s.leader_one_crack.counted, ElementsAre(1, 1, 1, 1));
  EXPECT_NEAR(s.leader_two_cracks.z_mean[2], 66 * mm, 1e-12);
  EXPECT_THAT(s.leader_two_cracks.counted, ElementsAre(1, 0, 1, 1));
  EXPECT_NEAR(s.leader.z_mean[2], 66 * mm, 1e-12);
  EXPECT_THAT(s.leader.reached, ElementsAre(3, 2, 3, 3));
}

TEST(LeaderStatistics, TheOrderOfFinishingPlaysNoPart) {
  const int n = 60;
  RandomStream random(1, 0, "test");
  std::vector<SampleSummary> rows;
  for (int i = 0; i < n; ++i) {
    std::vector<double> z(8, none);
    for (double& value : z)
      if (random.uniform() < 0.8) value = 65 + 10 * random.uniform();
    rows.push_back(row(static_cast<int>(random.bits() % 3) - 1, z, static_cast<Pattern>(random.bits() % 4)));
  }
  rows[9] = empty_summary(2, 4, SampleStatus::failed, "broke");
  const Statistics expected = make_statistics(rows, parameters(n));
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (int trial = 0; trial < 5; ++trial) {
    for (std::size_t i = order.size(); i-- > 1;) std::swap(order[i], order[random.bits() % (i + 1)]);
    RunningStatistics running(parameters(n));
    for (const std::size_t i : order) running.add(i, rows[i]);
    Statistics found = running.statistics();
    std::vector<const RankStatistics*> of;
    for_each_rank(expected, [&](const char*, const RankStatistics& ranks) { of.push_back(&ranks); });
    std::size_t next = 0;
    for_each_rank(found, [&](const char* name, const RankStatistics& ranks) {
      const RankStatistics& same = *of[next++];
      for (const auto field : {&PathStatistics::z_mean, &PathStatistics::z_std, &PathStatistics::z_half_width,
                               &PathStatistics::z_quantile, &PathStatistics::running_mean})
        EXPECT_EQ(bits(ranks.*field), bits(same.*field)) << name;
      EXPECT_EQ(ranks.reached, same.reached) << name;
      EXPECT_EQ(ranks.counted, same.counted) << name;
    });
    EXPECT_EQ(running.leader_position(2).mean, expected.leader.z_mean[2]);
  }
}

TEST(LeaderStatistics, TheRunningMeanIsThatOfTheClassThatArrivesMost) {
  RunningStatistics running(3, 2, 4, 0.95);
  EXPECT_TRUE(std::isnan(running.leader_position(0).mean));
  running.add(0, row(1, {none, none, none, none, 70, 71, 72, 73}));
  EXPECT_EQ(running.leader_position(2).mean, 72 * mm);
  running.add(1, row(0, {67, 67, 67, 67, none, none, none, none}));
  EXPECT_EQ(running.leader_position(2).mean, 67 * mm) << "of equals the first";
  running.add(2, row(1, {none, none, none, none, 70, 71, 74, 73}));
  EXPECT_NEAR(running.leader_position(2).mean, 73 * mm, 1e-12);
}

TEST(LeaderStatistics, LeadersThatAreNoNotchAreRefused) {
  for (const int leading : {-2, 2})
    EXPECT_THROW(make_statistics(std::vector{row(leading, std::vector<double>(8, none))}, 2, 4),
                 std::invalid_argument);
}

TEST(LeaderStatistics, TheRuleToStopLooksAtLeaders) {
  // Leaders of both notches are close together, followers are not.
  const int n = 100;
  const auto rows = [&](double of_leaders, double of_followers) {
    RandomStream random(7, 0, "test");
    std::vector<SampleSummary> result;
    for (int i = 0; i < n; ++i) {
      std::vector<double> z;
      for (int p = 0; p < 8; ++p)
        z.push_back(p < 4 ? 67 + of_leaders * random.uniform() : 73 + of_followers * random.uniform());
      result.push_back(row(0, z));
      if (random.uniform() < 0.5) result.back() = turned(result.back());
    }
    return result;
  };
  input::Parameters p = parameters(n);
  p.ensemble.stop = input::EnsembleStop{0.1 * mm, 0.95, 20};
  EXPECT_EQ(make_statistics(rows(0.1, 4), p).n_needed, 20);
  EXPECT_EQ(make_statistics(rows(4, 0.1), p).n_needed, n);
}

TEST(LeaderStatistics, TheTextTellsRanksApart) {
  const std::vector<SampleSummary> samples{
      row(0, {67, 66.8, 66.5, 66.9, none, none, none, 73}, Pattern::one_crack),
      turned(row(0, {67.2, none, 66.7, none, none, none, 69, 73.2})),
      row(-1, std::vector<double>(8, none), Pattern::none)};
  const std::string text = to_text(make_statistics(samples, parameters(3)), samples, sections);
  std::printf("%s", text.c_str());
  EXPECT_THAT(text,
              ::testing::HasSubstr("\nleading crack start: notch 0 in 1 sample, notch 1 in 1, none in 1\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("by rank; samples led by notch 1 are mapped by the body's symmetry, "
                                         "as if notch 0 led\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex(
                        "\nleader +notch 0 +notch 0 +y = 7 mm +z +2 +67\\.100 +0\\.141 +1\\.271 +2\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex(
                        "\nleader, one crack +notch 0 +notch 0 +y = 12\\.25 mm +z +1 +66\\.500 +- +- +1\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nfollower +notch 0 +notch 1 +y = 17\\.5 mm +z +2 +73\\.100 "));
  EXPECT_THAT(text, ::testing::HasSubstr("\nall cracks of the start, leading and following\nstart "));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nnotch 0 +y = 7 mm +z +2 +66\\.900 "));
  EXPECT_THAT(text, ::testing::HasSubstr(interval_scope(input::Base::shared)));
}

TEST(LeaderStatistics, TheTextKnowsGroupsOfBothNotches) {
  std::vector<SampleSummary> samples;
  for (int i = 0; i < 20; ++i) {
    const double z = (i % 4 < 2 ? 50 : 70) + 0.1 * i;
    const SampleSummary one = row(0, {z, none, none, none, none, none, none, none}, Pattern::one_crack);
    samples.push_back(i % 2 == 0 ? one : turned(one));
  }
  const Statistics found = make_statistics(samples, parameters(20));
  EXPECT_THAT(found.is_divided, ElementsAre(1, 0, 0, 0, 0, 0, 0, 1));
  const std::string text = to_text(found, samples, sections);
  std::printf("%s", text.c_str());
  EXPECT_THAT(text, ::testing::ContainsRegex("\nnotch 0 +y = 7 mm +z +10 +groups +- +-\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nnotch 1 +y = 17\\.5 mm +z +10 +groups +- +-\n"));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
