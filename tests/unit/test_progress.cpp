// SPDX-License-Identifier: GPL-3.0-or-later
// Progress shown to the user: counts, time left, means; the line on a terminal and in a log.
#include "common/text_table.h"
#include "ensemble/group.h"
#include "ensemble/progress.h"
#include "ensemble/run_log.h"
#include "support/geometry_bodies.h"
#include "support/temporary_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

SampleReport done(std::uint64_t sample, double force, double z_middle) {
  SampleReport report;
  report.sample = sample;
  report.summary = analysis::SampleSummary{};
  report.summary.status = analysis::SampleStatus::done;
  report.summary.onset_force = force;
  const double elsewhere = std::isnan(z_middle) ? nan : 0;
  report.summary.position = {elsewhere, z_middle, elsewhere, elsewhere, elsewhere, elsewhere};
  report.summary.z_spread.resize(6);
  report.summary.leading_start = 0;
  report.stored = true;
  return report;
}

SampleReport failed(std::uint64_t sample) {
  SampleReport report;
  report.sample = sample;
  report.summary.status = analysis::SampleStatus::failed;
  report.summary.error = "computation: energy blew up";
  report.seconds = 2;
  return report;
}

/// Two notches, three sections.
Progress make_progress(std::size_t n_to_do, int n_groups, std::size_t n_starts = 2) {
  input::Parameters parameters;
  parameters.ensemble.samples = 200;
  parameters.specimen.size = {0.005, 0.0245, 0.14};
  // With different depths: no symmetry maps one onto the other.
  for (std::size_t i = 0; i < n_starts; ++i)
    parameters.specimen.notches.push_back(
        crackle::testing::notch(i == 0 ? plane::Face::y_min : plane::Face::y_max, 65, 5 + double(i), 0.6));
  parameters.sections.y = {0.007, 0.01225, 0.0175};
  return {n_to_do, n_groups, parameters};
}

TEST(Progress, CountsEverySampleOnce) {
  auto progress = make_progress(5, 2);
  progress.kept(0, done(0, 400, 0.07).summary);
  progress.kept(1, failed(1).summary);
  EXPECT_EQ(progress.n_left(), 5);
  progress.started(2, 0);
  progress.started(3, 0);
  EXPECT_EQ(progress.n_running(), 2);
  EXPECT_EQ(progress.n_left(), 3);
  progress.finished(done(3, 410, 0.07), 10);
  progress.finished(failed(4), 11);  // its mesh failed: it was never handed out
  EXPECT_EQ(progress.n_done(), 2);
  EXPECT_EQ(progress.n_failed(), 2);
  EXPECT_EQ(progress.n_running(), 1);
  EXPECT_EQ(progress.n_left(), 2);
}

TEST(Progress, WatchesASectionThatNotch0CanReach) {
  input::Parameters parameters;
  parameters.ensemble.samples = 2;
  parameters.specimen = {{0.005, 0.0245, 0.14},
                         {crackle::testing::notch(plane::Face::z_min, 12, 5, 0.6),
                          crackle::testing::notch(plane::Face::y_max, 65, 5, 0.6)}};
  parameters.sections = {.y = {0.007}, .z = {0.03, 0.04}};
  Progress progress(2, 1, parameters);
  auto report = done(0, 400, 0);
  report.summary.position = {nan, 0.0121, 0.0122, 0.065, nan, nan};
  progress.finished(report, 10);
  EXPECT_EQ(progress.mean_position().second, 0.0122);
  EXPECT_THAT(progress.means(), HasSubstr("mean y of leading cracks at z = 40 mm: 12.200 mm"));
}

TEST(Progress, WatchesASectionThatMostLeadingCracksCross) {
  auto progress = make_progress(4, 1, 1);
  for (std::uint64_t sample = 0; sample < 4; ++sample) {
    auto report = done(sample, 400, 0);
    // As if the middle section lay in a hole, which one crack of four passes by.
    report.summary.position = {0.07, sample == 0 ? 0.08 : nan, 0.071};
    report.summary.z_spread.resize(3);
    progress.finished(report, 10);
  }
  EXPECT_EQ(progress.mean_position().first, 0u);
  EXPECT_DOUBLE_EQ(progress.mean_position().second, 0.07);
}

TEST(Progress, WatchesASectionWhereLeadersAreInOneGroup) {
  auto progress = make_progress(20, 1, 1);
  for (std::uint64_t sample = 0; sample < 20; ++sample) {
    auto report = done(sample, 400, 0);
    const double along = 1e-4 * static_cast<double>(sample);
    report.summary.position = {0.07 + along, (sample % 2 == 0 ? 0.05 : 0.08) + along, 0.071 + along};
    report.summary.z_spread.resize(3);
    progress.finished(report, 10);
  }
  EXPECT_EQ(progress.mean_position().first, 0u);
  EXPECT_THAT(progress.means(), HasSubstr("at y = 7 mm: 70.950 mm"));
}

TEST(Progress, MeansLeaveOutWhatDidNotArrive) {
  auto progress = make_progress(4, 1);
  EXPECT_TRUE(std::isnan(progress.mean_position().second));
  EXPECT_TRUE(std::isnan(progress.statistics().median_load().median.value));
  progress.kept(0, done(0, 400, 0.070).summary);
  progress.finished(done(1, 420, 0.072), 1);
  progress.finished(done(2, nan, nan), 2);
  progress.finished(failed(3), 3);
  EXPECT_DOUBLE_EQ(progress.mean_position().second, 0.071);
  EXPECT_DOUBLE_EQ(progress.statistics().median_load().median.value, 410);
}

TEST(Progress, SamplesThatDidNotBreakAreStronger) {
  auto progress = make_progress(5, 1);
  const auto unbroken = [](std::uint64_t sample) {
    auto report = done(sample, nan, nan);
    report.summary.outcome = 0;
    report.summary.peak_load = 60;
    return report;
  };
  progress.finished(done(0, 40, nan), 1);
  progress.finished(done(1, 50, nan), 1);
  progress.finished(unbroken(2), 1);
  EXPECT_EQ(progress.means(), "median onset 50.000 N (1 of 3 unbroken)");
  progress.finished(unbroken(3), 1);
  progress.finished(unbroken(4), 1);
  EXPECT_EQ(progress.means(), "median onset above 60.000 N (3 of 5 unbroken)");
  EXPECT_THAT(describe(unbroken(2)), HasSubstr("done: unbroken, held 60.0 N, no main crack"));
}

TEST(Progress, ThePeakLoadIsTheHeadlineWhereTheOnsetIsLate) {
  auto progress = make_progress(2, 1);
  auto late = done(0, 0.2, nan);
  late.summary.peak_load = 740;
  progress.finished(late, 1);
  EXPECT_EQ(progress.means(), "median peak load 740.000 N");
  EXPECT_THAT(describe(late), HasSubstr("peak load 740.0 N, onset 0.2 N, "));
}

TEST(Progress, TimeLeftFollowsFromMeanDurationAndGroups) {
  auto progress = make_progress(9, 2);
  EXPECT_TRUE(std::isnan(progress.time_left(0)));
  progress.started(0, 0);
  EXPECT_TRUE(std::isnan(progress.time_left(5)));
  progress.finished(done(0, 400, 0.07), 10);
  progress.started(1, 10);
  progress.started(2, 10);
  // 6 left with 10 s each, and 2 running with 6 s to go: 72 s of work for 2 groups.
  EXPECT_DOUBLE_EQ(progress.time_left(14), 36);
}

TEST(Progress, LastSampleBoundsTheTimeLeft) {
  auto progress = make_progress(2, 8);
  progress.started(0, 0);
  progress.started(1, 4);
  progress.finished(done(0, 400, 0.07), 10);
  EXPECT_DOUBLE_EQ(progress.time_left(10), 4);
  EXPECT_DOUBLE_EQ(progress.time_left(100), 0);
  progress.finished(done(1, 400, 0.07), 14);
  EXPECT_DOUBLE_EQ(progress.time_left(14), 0);
}

TEST(Progress, LineSaysAll) {
  auto progress = make_progress(200, 2);
  progress.started(0, 0);
  EXPECT_EQ(progress.line(1), "0 done, 0 failed, 1 running, 199 pending");
  progress.finished(done(0, 402.34, 0.06831), 120);
  progress.started(1, 120);
  const std::string line = progress.line(120);
  std::printf("%s\n", line.c_str());
  EXPECT_EQ(line,
            "1 done, 0 failed, 1 running, 198 pending, about 3 h 19 min remaining; mean z of leading cracks "
            "at y = 12.25 mm: "
            "68.310 mm, median onset "
            "402.340 N");
}

TEST(Progress, LineSaysWhereTheOnlyRunningSampleStands) {
  auto progress = make_progress(4, 2);
  progress.started(2, 0);
  progress.at_work("dynamic phase 1: 40 %");
  EXPECT_EQ(progress.line(1), "0 done, 0 failed, 1 running, 3 pending; sample 2: dynamic phase 1: 40 %");
  progress.started(3, 1);
  EXPECT_EQ(progress.line(1), "0 done, 0 failed, 2 running, 2 pending");
}

TEST(Progress, SamplesAreListedAsRanges) {
  const auto text = [](std::vector<std::uint64_t> samples) { return format_samples(samples); };
  EXPECT_EQ(text({4}), "sample 4");
  EXPECT_EQ(text({0, 1}), "samples 0-1");
  EXPECT_EQ(text({3, 4, 5, 6, 20, 22, 23}), "samples 3-6, 20, 22-23");
}

TEST(Progress, BodyWithoutNotchesHasNoPosition) {
  Progress progress = make_progress(1, 1, 0);
  auto report = done(0, 400, 0.07);
  report.summary.position.clear();
  report.summary.z_spread.clear();
  report.summary.leading_start = -1;
  progress.finished(report, 1);
  EXPECT_EQ(progress.line(1), "1 done, 0 failed, 0 running, 0 pending; median onset 400.000 N");
}

TEST(Progress, DurationsReadWell) {
  EXPECT_EQ(duration_text(0.2), "0.2 s");
  EXPECT_EQ(duration_text(59.6), "1 min 0 s");
  EXPECT_EQ(duration_text(754), "12 min 34 s");
  EXPECT_EQ(duration_text(12000), "3 h 20 min");
  EXPECT_EQ(duration_text(2 * 86400 + 3 * 3600 + 59 * 60), "2 d 3 h");
}

TEST(SampleReport, OneLineForEachSample) {
  auto report = done(3, 380.94, 0.07);
  report.summary.outcome = 2;
  report.summary.pattern = 1;
  report.summary.crack_area = 61.25e-6;
  report.summary.breaks = 1532;
  report.summary.energy_error = 2.1e-5;
  report.seconds = 41.04;
  EXPECT_EQ(
      describe(report),
      "sample 3 done: separated, onset 380.9 N, one crack, 61.2 mm^2 of rough crack, 1532 breaks, energy "
      "error 2.1e-05, "
      "41.0 s");
  report.summary.onset_force = std::nan("");
  report.summary.first_break_load = 250;
  report.summary.note = "what is to be known";
  EXPECT_THAT(describe(report),
              ::testing::AllOf(::testing::HasSubstr("done: separated, first break at 250.0 N, one crack"),
                               ::testing::EndsWith("41.0 s; what is to be known")));
  EXPECT_EQ(describe(failed(4)), "sample 4 failed after 2.0 s: computation: energy blew up");
}

struct Screen {
  double time = 0;
  std::ostringstream out;
  RunLog log;
  explicit Screen(int width) : log(out, width, [this] { return time; }) {}
  std::string take() {
    auto text = out.str();
    out.str("");
    return text;
  }
};

TEST(RunLog, LogHasPlainLinesAndProgressAtMostEvery30Seconds) {
  Screen screen(0);
  auto progress = make_progress(10, 1);
  screen.log.show(progress, true);
  EXPECT_EQ(screen.take(), "0 done, 0 failed, 0 running, 10 pending\n");
  screen.time = 29;
  screen.log.show(progress, true);
  EXPECT_EQ(screen.take(), "");
  screen.log.line("sample 0 done");
  EXPECT_EQ(screen.take(), "sample 0 done\n");
  screen.time = 30;
  screen.log.show(progress, false);  // the news from second 29 are still pending
  EXPECT_THAT(screen.take(), HasSubstr("10 pending"));
  screen.time = 90;
  screen.log.show(progress, false);
  EXPECT_EQ(screen.take(), "") << "nothing new";
  EXPECT_THAT(screen.out.str(), Not(HasSubstr("\r")));
}

TEST(RunLog, TerminalHasOneLineThatRenewsItself) {
  Screen screen(200);
  auto progress = make_progress(10, 1);
  screen.log.show(progress, true);
  const std::string first = "0 done, 0 failed, 0 running, 10 pending";
  EXPECT_EQ(screen.take(), first);
  screen.log.show(progress, false);
  EXPECT_EQ(screen.take(), "");
  progress.started(0, 0);
  screen.log.show(progress, true);
  const std::string blank(first.size(), ' ');
  EXPECT_EQ(screen.take(), "\r" + blank + "\r0 done, 0 failed, 1 running, 9 pending");
  screen.time = 1;
  screen.log.show(progress, false);
  EXPECT_THAT(screen.take(), HasSubstr("9 pending")) << "the time left runs on";
  screen.log.line("sample 0 done");
  EXPECT_THAT(screen.take(), HasSubstr("\rsample 0 done\n0 done, 0 failed, 1 running, 9 pending"));
  screen.log.end_progress();
  screen.take();
  screen.log.line("end");
  EXPECT_EQ(screen.take(), "end\n");
}

TEST(RunLog, AnyLineRenewsItselfAndIsMadeOnlyWhenItIsShown) {
  Screen screen(40);
  int n_made = 0;
  const auto line = [&] { return fmt::format("{} %", 10 * ++n_made); };
  for (screen.time = 0; screen.time < 3; screen.time += 0.25) screen.log.show(line, false);
  EXPECT_EQ(n_made, 3);
  EXPECT_EQ(screen.take(), "10 %\r    \r20 %\r    \r30 %");
}

/// A sweep keeps one per case, up to 1000.
TEST(RunLog, KeptLogsHoldNoFilesOpen) {
  const test::TemporaryFolder folder;
  const auto n_open = [] {
    const fs::directory_iterator descriptors("/proc/self/fd");
    return std::distance(begin(descriptors), end(descriptors));
  };
  const auto before = n_open();
  std::deque<Screen> screens;
  for (int i = 0; i < 20; ++i) {
    screens.emplace_back(0).log.keep(folder.path() / std::to_string(i));
    for (const char* text : {"first", "second"}) screens.back().log.line(text);
  }
  EXPECT_EQ(n_open(), before);
  std::ifstream kept(folder.path() / "19");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(kept), {}), "first\nsecond\n");
}

TEST(RunLog, ProgressFitsTheTerminal) {
  Screen screen(20);
  screen.log.show(make_progress(10, 1), true);
  EXPECT_EQ(screen.take(), "0 done, 0 failed, 0");
}

TEST(GroupLayout, MasterGroupsAndLeftOverRanks) {
  const auto layout = make_group_layout(8, 3);
  EXPECT_EQ(layout.n_groups, 2);
  EXPECT_EQ(layout.n_left_over, 1);
  std::vector<int> groups;
  for (int rank = 0; rank < 8; ++rank) groups.push_back(layout.group_of(rank));
  EXPECT_EQ(groups, (std::vector<int>{-1, 0, 0, 0, 1, 1, 1, -1}));
  EXPECT_EQ(layout.root_of(1), 4);
  EXPECT_EQ(describe(layout), "8 ranks: master on rank 0, 2 groups of 3; rank 7 stays idle");
  EXPECT_EQ(describe(make_group_layout(9, 3)),
            "9 ranks: master on rank 0, 2 groups of 3; ranks 7 to 8 stay idle");
  EXPECT_EQ(describe(make_group_layout(3, 2)), "3 ranks: master on rank 0, 1 group of 2");
}

TEST(GroupLayout, OneRankIsMasterAndWorker) {
  for (const int ranks_per_sample : {1, 4}) {
    const auto layout = make_group_layout(1, ranks_per_sample);
    EXPECT_TRUE(layout.shared());
    EXPECT_EQ(layout.group_of(0), 0);
    EXPECT_EQ(layout.root_of(0), 0);
  }
}

TEST(GroupLayout, TooFewRanksAreRefusedWithTheNumberNeeded) {
  try {
    make_group_layout(4, 4);
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("ensemble.ranks_per_sample = 4 needs at least 5 ranks"));
    EXPECT_THAT(error.what(), HasSubstr("there are 4"));
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
