// SPDX-License-Identifier: GPL-3.0-or-later
// Any stage of a sample may fail on any rank of its group: the sample fails with stage and reason, the other
// samples of the ensemble are bitwise equal to those of an undisturbed run, and nothing deadlocks.
#include "common/index.h"
#include "ensemble/run.h"
#include "input/reader.h"
#include "io/sample_file.h"
#include "mechanics/static_solver.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "support/effort.h"
#include "support/group.h"
#include "support/result_comparison.h"
#include "support/temporary_folder.h"
#include "two_pieces.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

namespace fs = std::filesystem;

/// A bar pulled slowly until it breaks, arrests, and breaks again.
input::Parameters bar(int samples, int ranks_per_sample) {
  return input::parse(fmt::format(R"([ensemble]
samples = {}
seed = 7
ranks_per_sample = {}
[specimen]
size = ["3 mm", "5 mm", "9 mm"]
[[specimen.notch]]
face = "y-min"
at = "4 mm"
depth = "1.5 mm"
height = "1 mm"
[mesh]
base = "shared"
spacing = "1.5 mm"
notch_spacing = "1 mm"
growth = 0.5
perturbation = 0.2
min_quality = 0.05
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.38
density = "1180 kg/m^3"
[fracture]
strength = "35 MPa"
exponent = 2
impulse = "1e-8 MPa^2 s"
accumulation = "cumulative"
release = "facet"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "10 N"]
rate = ["0 N/s", "0 N/s", "5 N/s"]
[time]
duration = "6 us"
[sections]
y = ["3 mm"]
[output]
frames = 2
)",
                                  samples, ranks_per_sample),
                      "bar.toml");
}

/// Aborts the program when a rank of the group has entered no stage for long, and reports what was under way.
class Watchdog {
public:
  explicit Watchdog(int rank) : thread_([this, rank](const std::stop_token& stop) { watch(stop, rank); }) {}

  void begin(std::string what) {
    const std::scoped_lock lock(mutex_);
    what_ = std::move(what);
    is_new_ = true;
    changed_.notify_all();
  }

private:
  static constexpr std::chrono::seconds patience{180};

  void watch(const std::stop_token& stop, int rank) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      is_new_ = false;
      if (changed_.wait_for(lock, stop, patience, [this] { return is_new_; }) || stop.stop_requested())
        continue;
      std::fprintf(stderr, "rank %d: no end for %d s after: %s\n", rank, static_cast<int>(patience.count()),
                   what_.c_str());
      std::_Exit(EXIT_FAILURE);
    }
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string what_ = "the start";
  bool is_new_ = false;
  std::jthread thread_;  // last member: joined before the others are destroyed
};

constexpr int n_kinds = 3;
const char* const words[n_kinds] = {"bad_alloc", "No space left on device",
                                    "static equilibrium: no convergence"};

[[noreturn]] void fail(int kind) {
  if (kind == 0) throw std::bad_alloc();
  if (kind == 1) throw std::system_error(std::make_error_code(std::errc::no_space_on_device), "0007.h5");
  throw mechanics::NoEquilibrium(words[2]);
}

class FailingStages : public testing::Test {
protected:
  void SetUp() override {
    if (world_.size() < 3) GTEST_SKIP() << "needs a master and a group of two or three ranks";
    if (world_.is_root())
      folder_.emplace();
    else
      watchdog_.emplace(world_.rank());
    root_ = parallel::share(world_, folder_ ? folder_->path().string() : "");
  }
  void TearDown() override { MPI_Barrier(world_.get()); }

  /// This rank's number in its group; negative on the master.
  int rank_in_group() const { return world_.rank() - 1; }
  int group_size() const { return world_.size() - 1; }
  static constexpr int all_ranks = -1;

  struct Fault {
    int rank;      // in the group, or all_ranks
    int kind;      // of the fault's message
    bool is_late;  // occurs when the stage is entered for the last time, not for the first
  };

  /// The faults of samples 1, 2, ... in the test of a stage; before and after them is an undisturbed sample.
  /// On every rank of the group one kind, another at each stage; in a group of two every kind under
  /// tools/check --full.
  std::vector<Fault> faults_in(std::size_t number_of_stage) const {
    const bool has_every_kind = group_size() == 2 && test::is_full();
    std::vector<Fault> faults;
    for (int rank = 0; rank < group_size(); ++rank) {
      for (int kind = 0; kind < n_kinds; ++kind) {
        if (!has_every_kind && kind != (rank + static_cast<int>(number_of_stage)) % n_kinds) continue;
        faults.push_back({rank, kind, kind == 1});
      }
    }
    faults.push_back({all_ranks, 2, false});
    return faults;
  }
  int n_samples() const { return static_cast<int>(faults_in(0).size()) + 2; }

  RunOutcome run(const std::string& name, const decltype(RunOptions::enter)& enter) {
    const auto parameters = bar(n_samples(), group_size());
    RunOptions options{.folder = root_ / name, .log = &log_};
    options.enter = enter;
    log_.str("");
    return ensemble::run(world_, parameters, {}, options, dynamics::in_two_pieces);
  }

  void expect_same(const std::string& name, int sample) {
    const auto file = [&](const std::string& folder) {
      return io::sample_path(root_ / folder, static_cast<std::uint64_t>(sample));
    };
    EXPECT_EQ(io::differences(file("undisturbed"), file(name)), std::vector<std::string>{})
        << name << ", sample " << sample;
  }

  /// The stages that a rank of the group enters, each once, in order.
  std::vector<std::string> stages_of(int rank, const std::vector<std::string>& mine) {
    std::string text;
    if (rank_in_group() == rank)
      for (const auto& stage : mine) text += stage + '\n';
    const auto all = parallel::gather_all<char>(world_, text);
    std::vector<std::string> stages;
    std::istringstream lines(std::string(all.begin(), all.end()));
    for (std::string line; std::getline(lines, line);) stages.push_back(line);
    return stages;
  }

  parallel::Communicator world_{test::group()};
  std::optional<Watchdog> watchdog_;             // on the ranks of the group
  std::optional<test::TemporaryFolder> folder_;  // on rank 0
  fs::path root_;
  std::ostringstream log_;
};

TEST_F(FailingStages, FailOneSampleAndEndNothingElse) {
  std::vector<std::string> entered;
  std::map<std::pair<std::uint64_t, std::string>, int> n_entered;  // by sample and stage
  const auto undisturbed = run("undisturbed", [&](std::uint64_t sample, std::string_view stage) {
    watchdog_->begin(fmt::format("sample {}, '{}' (undisturbed)", sample, stage));
    if (std::ranges::find(entered, stage) == entered.end()) entered.emplace_back(stage);
    ++n_entered[{sample, std::string(stage)}];
  });
  ASSERT_EQ(undisturbed.done, n_samples()) << log_.str();
  const auto of_root = stages_of(0, entered);
  EXPECT_THAT(of_root,
              testing::IsSupersetOf({"partition", "sharing", "restoring", "set-up", "quasi-static loading",
                                     "static solve", "dynamic phase", "energy row", "frame", "time steps",
                                     "saving", "results", "analysis", "writing"}));
  const auto of_others = stages_of(group_size() - 1, entered);

  for (std::size_t number = 0; number < of_root.size(); ++number) {
    const auto& stage = of_root[number];
    const bool is_shared = std::ranges::find(of_others, stage) != of_others.end();
    const auto faults = faults_in(number);
    const auto comes = [&](const Fault& fault) { return is_shared || fault.rank <= 0; };
    std::map<std::uint64_t, int> n_now;
    const auto outcome = run(stage, [&](std::uint64_t sample, std::string_view now) {
      watchdog_->begin(fmt::format("sample {}, '{}' (fault in '{}')", sample, now, stage));
      if (now != stage || sample == 0 || sample > faults.size()) return;
      const Fault& fault = faults[sample - 1];
      if (fault.rank != all_ranks && fault.rank != rank_in_group()) return;
      if (++n_now[sample] == (fault.is_late ? n_entered.at({sample, stage}) : 1)) fail(fault.kind);
    });
    const auto n_failing = static_cast<int>(std::ranges::count_if(faults, comes));
    EXPECT_EQ(outcome.failed, n_failing) << stage << '\n' << log_.str();
    EXPECT_EQ(outcome.done, n_samples() - n_failing) << stage << '\n' << log_.str();
    EXPECT_EQ(outcome.file_error, "");
    if (!world_.is_root()) continue;
    for (int sample = 1; sample <= static_cast<int>(faults.size()); ++sample) {
      const Fault& fault = faults[index(sample) - 1];
      if (!comes(fault)) {
        expect_same(stage, sample);
        continue;
      }
      EXPECT_THAT(log_.str(), testing::ContainsRegex(fmt::format("sample {} failed after .*: {}: [^\n]*{}",
                                                                 sample, stage, words[fault.kind])));
    }
    expect_same(stage, 0);
    expect_same(stage, n_samples() - 1);
  }
  if (world_.is_root())
    std::printf("%zu stages, %zu of them on all %d ranks of a group\n", of_root.size(), of_others.size(),
                group_size());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
