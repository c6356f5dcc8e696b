// SPDX-License-Identifier: GPL-3.0-or-later
// Whole ensembles with real meshes and files, and a cheap rule instead of the mechanics.
#include "crackle/crackle.h"
#include "io/checkpoint_file.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "strip_plate.h"
#include "support/group.h"
#include "support/result_comparison.h"
#include "support/temporary_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

namespace fs = std::filesystem;
using analysis::SampleStatus;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Expects ensemble.h5 and all sample files to be equal except for times and provenance.
void expect_same_ensemble(const fs::path& a, const fs::path& b, std::uint64_t n_samples) {
  EXPECT_THAT(io::differences(a / "ensemble.h5", b / "ensemble.h5"), IsEmpty());
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    EXPECT_THAT(io::differences(io::sample_path(a, sample), io::sample_path(b, sample)), IsEmpty()) << sample;
  }
}

/// Names and contents of everything in a folder.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::ifstream stream(entry.path(), std::ios::binary);
    files[entry.path().string()] =
        entry.is_directory() ? "" : std::string{std::istreambuf_iterator<char>(stream), {}};
  }
  return files;
}

class EnsembleRun : public testing::Test {
protected:
  void SetUp() override {
    if (world_.is_root()) folder_.emplace();
    root_ = parallel::share(world_, folder_ ? folder_->path().string() : "");
  }
  void TearDown() override { MPI_Barrier(world_.get()); }

  RunOutcome run(const std::string& name, const input::Parameters& parameters, bool resume,
                 const Mechanics& function = strip) {
    return run_on(world_, name, parameters, resume, function);
  }
  RunOutcome run_on(const parallel::Communicator& ranks, const std::string& name,
                    const input::Parameters& parameters, bool resume, const Mechanics& function = strip) {
    log_.str("");
    return ensemble::run(ranks, parameters, {},
                         {.folder = root_ / name, .plan = {.resume = resume}, .log = &log_}, function);
  }

  /// One sample, on all ranks as a group.
  RunOutcome run_single(const std::string& name, const input::Parameters& parameters, const PlanOptions& plan,
                        const Mechanics& function = strip) {
    log_.str("");
    return ensemble::run(world_, parameters, {}, {.folder = root_ / name, .plan = plan, .log = &log_},
                         function);
  }

  /// The samples for which a function was called on the roots of groups, over all ranks.
  std::vector<std::uint64_t> computed() {
    std::vector<int> counts(20, 0);
    for (const auto sample : computed_here_) ++counts.at(sample);
    MPI_Allreduce(MPI_IN_PLACE, counts.data(), 20, MPI_INT, MPI_SUM, world_.get());
    std::vector<std::uint64_t> samples;
    for (std::size_t i = 0; i < counts.size(); ++i)
      samples.insert(samples.end(), static_cast<std::size_t>(counts[i]), i);
    computed_here_.clear();
    return samples;
  }
  Mechanics recording(const Mechanics& function) {
    return [this, function](const auto& group, const auto& model, const auto& output, const auto& subdomain,
                            const auto& control) {
      if (group.is_root()) computed_here_.push_back(control.sample);
      return function(group, model, output, subdomain, control);
    };
  }

  /// Four samples on all ranks, on one, a single sample, and an ensemble that has lost one sample.
  void expect_same_alone_on_many_ranks_and_resumed(const input::Parameters& parameters) {
    EXPECT_EQ(run("all", parameters, false).done, 4);
    const std::string log = log_.str();
    EXPECT_EQ(run_single("one", parameters, {.single = 2}).done, 1);
    log_.str(log);
    if (world_.is_root()) {
      EXPECT_THAT(log_.str(), HasSubstr(parameters.mesh.base == input::Base::own
                                            ? "base mesh: one for each sample, about "
                                            : "base mesh: "));
      EXPECT_THAT(io::differences(io::sample_path(root_ / "one", 2), io::sample_path(root_ / "all", 2)),
                  IsEmpty());
      run_on(parallel::Communicator(MPI_COMM_SELF), "alone", parameters, false);
      expect_same_ensemble(root_ / "all", root_ / "alone", 4);
      fs::copy(root_ / "all", root_ / "cut", fs::copy_options::recursive);
      fs::remove(root_ / "cut" / "ensemble.h5");
      fs::remove(io::sample_path(root_ / "cut", 1));
    }
    MPI_Barrier(world_.get());
    EXPECT_EQ(run("cut", parameters, true, recording(strip)).done, 4);
    EXPECT_THAT(computed(), ElementsAre(1));
    if (world_.is_root()) expect_same_ensemble(root_ / "all", root_ / "cut", 4);
  }

  parallel::Communicator world_{test::group()};
  std::optional<test::TemporaryFolder> folder_;  // on rank 0
  fs::path root_;
  std::ostringstream log_;
  std::vector<std::uint64_t> computed_here_;
};

TEST_F(EnsembleRun, SameEnsembleOnAnyNumberOfRanks) {
  const auto parameters = plate(5, 1);
  const auto outcome = run("all", parameters, false, recording(strip));
  EXPECT_EQ(outcome.done, 5);
  EXPECT_EQ(outcome.failed + outcome.left, 0);
  EXPECT_EQ(outcome.file_error, "");
  EXPECT_THAT(computed(), ElementsAre(0, 1, 2, 3, 4));
  if (!world_.is_root()) return;
  EXPECT_THAT(log_.str(), HasSubstr("5 of 5 samples to compute"));
  EXPECT_THAT(log_.str(), HasSubstr("base mesh: "));
  EXPECT_THAT(log_.str(), HasSubstr("sample 4 done: separated, onset 384.0 N"));
  EXPECT_THAT(log_.str(), HasSubstr("5 done, 0 failed, 0 pending after"));

  const auto content = io::read_ensemble(root_ / "all" / "ensemble.h5");
  EXPECT_EQ(content.input_text, parameters.text);
  const auto base =
      geometry::make_mother_points(*geometry::make_body(parameters), parameters.mesh, parameters.seed);
  EXPECT_EQ(content.base.position, base.position);
  EXPECT_EQ(content.base.spacing, base.spacing);
  EXPECT_EQ(content.base.movable, base.movable);
  EXPECT_GT(content.samples[0].crack_area, 0);
  EXPECT_NE(content.samples[0].crack_area, content.samples[1].crack_area) << "samples differ";
  // The statistics merged by the master match those in the file.
  const double median = analysis::quantile({380, 381, 382, 383, 384}, 0.5);
  EXPECT_THAT(log_.str(),
              HasSubstr(fmt::format(
                  "\nmean z of leading cracks at y = 10 mm: {:.3f} mm, median onset {:.3f} N\n",
                  analysis::make_statistics(content.samples, parameters).leader.z_mean[1] * 1e3, median)));
  std::printf("crack areas %.3f and %.3f mm^2, first crossing at %.3f mm\n",
              content.samples[0].crack_area * 1e6, content.samples[1].crack_area * 1e6,
              content.samples[0].position.at(0) * 1e3);

  run_on(parallel::Communicator(MPI_COMM_SELF), "alone", parameters, false);
  expect_same_ensemble(root_ / "all", root_ / "alone", 5);
}

TEST_F(EnsembleRun, SameEnsembleWithTwoRanksPerSample) {
  if (world_.size() == 2) GTEST_SKIP() << "needs 1, 3 or 4 ranks";
  const auto parameters = plate(3, 2);
  EXPECT_EQ(run("all", parameters, false).done, 3);
  if (!world_.is_root()) return;
  if (world_.size() == 4) {
    EXPECT_THAT(log_.str(), HasSubstr("rank 3 stays idle"));
  }
  run_on(parallel::Communicator(MPI_COMM_SELF), "alone", parameters, false);
  expect_same_ensemble(root_ / "all", root_ / "alone", 3);
}

/// The same plate, with separate base points for each sample.
input::Parameters with_own_base(const input::Parameters& parameters) {
  std::string text = parameters.text;
  const std::string shared = "base = \"shared\"\n";
  return input::parse(text.erase(text.find(shared), shared.size()), "plate.toml");
}

TEST_F(EnsembleRun, SamplesWithABaseOfTheirOwnAreTheSameOnAnyNumberOfRanks) {
  expect_same_alone_on_many_ranks_and_resumed(with_own_base(plate(4, 1)));
  if (world_.is_root()) {
    EXPECT_EQ(io::read_ensemble(root_ / "all" / "ensemble.h5").base.size(), 0u);
  }
  // Samples of the other kind do not belong to it.
  MPI_Barrier(world_.get());
  EXPECT_THAT([&] { run("cut", plate(4, 1), true); },
              testing::ThrowsMessage<parallel::AgreedError>(HasSubstr("mesh.base is shared, not own")));
}

TEST_F(EnsembleRun, PlatesOfAnyOutlineAreTheSameOnAnyNumberOfRanks) {
  std::string text = plate(4, 1).text;
  const auto from = text.find("size ="), to = text.find("[mesh]");
  text.replace(from, to - from, R"(thickness = "4 mm"
outline = [["2 mm", "0 mm"], ["20 mm", "0 mm"], ["18 mm", "30 mm"], ["0 mm", "30 mm"]]
[[specimen.hole]]
center = ["13 mm", "22 mm"]
radius = "3 mm"
[[specimen.notch]]
from = ["0 mm", "12 mm"]
to = ["5 mm", "14 mm"]
height = "2 mm"
end = "round"
)");
  expect_same_alone_on_many_ranks_and_resumed(input::parse(text, "outline.toml"));
  if (!world_.is_root()) return;
  const auto content = io::read_ensemble(root_ / "all" / "ensemble.h5");
  EXPECT_EQ(content.samples[0].position.size(), 9u) << "the notch, the hole and the free surface, 3 sections";
  EXPECT_GT(content.samples[0].crack_area, 0);
}

TEST_F(EnsembleRun, PoisonedSampleFailsAlone) {
  const auto parameters = plate(4, 1);
  const auto outcome =
      run("out", parameters, false,
          [](const auto& group, const auto&, const auto&, const auto& subdomain, const auto& control) {
            if (control.sample == 2) throw std::runtime_error("injected");
            return break_strip(group, control.sample, subdomain);
          });
  EXPECT_EQ(outcome.done, 3);
  EXPECT_EQ(outcome.failed, 1);
  if (world_.is_root()) {
    const auto content = io::read_ensemble(root_ / "out" / "ensemble.h5");
    EXPECT_EQ(content.samples[2].status, SampleStatus::failed);
    EXPECT_EQ(content.samples[2].error, "computation: injected");
    EXPECT_EQ(content.samples[3].status, SampleStatus::done);
    EXPECT_THAT(log_.str(), HasSubstr("failed: sample 2: computation: injected"));
  }

  const auto again = run("out", parameters, true, recording(strip));
  EXPECT_THAT(computed(), IsEmpty()) << "a failed sample has ended";
  EXPECT_EQ(again.done, 3);
  EXPECT_EQ(again.failed, 1);
}

TEST_F(EnsembleRun, FailedSampleLeavesNoCheckpointAndIsTriedAgainFromItsBeginning) {
  const auto parameters = plate(3, 1);
  std::size_t found = 0;  // size of the checkpoints to continue from, on this rank [byte]
  const auto checkpointed = [&](bool fails) -> Mechanics {
    return [&found, fails](const auto& group, const auto& own, const auto& output, const auto& subdomain,
                           const dynamics::SampleControl& control) {
      const std::uint64_t sample = control.sample;
      found += control.checkpoint.size();
      const std::vector<std::byte> bytes(100);
      if (sample == 1 && group.is_root()) control.save(bytes);
      if (sample == 1 && fails) throw std::runtime_error("no memory");
      return strip(group, own, output, subdomain, control);
    };
  };
  EXPECT_EQ(run("retried", parameters, false, checkpointed(true)).failed, 1);
  if (world_.is_root()) {
    EXPECT_FALSE(fs::exists(io::checkpoint_path(root_ / "retried", 1)));
    // As left by a kill between the two.
    io::write_checkpoint(io::checkpoint_path(root_ / "retried", 1), input::sample_identity(parameters), 1,
                         std::vector<std::byte>(100));
  }
  MPI_Barrier(world_.get());
  log_.str("");
  const auto outcome = ensemble::run(
      world_, parameters, {},
      {.folder = root_ / "retried", .plan = {.resume = true, .retry_failed = true}, .log = &log_},
      checkpointed(false));
  EXPECT_EQ(outcome.done, 3);
  EXPECT_EQ(found, 0u);
  if (!world_.is_root()) return;
  EXPECT_THAT(log_.str(), HasSubstr("1 of them had failed and are computed again"));
  EXPECT_FALSE(fs::exists(io::checkpoint_path(root_ / "retried", 1)));
}

TEST_F(EnsembleRun, SuspendedSampleReportsThatItsCheckpointCouldNotBeKept) {
  if (world_.is_root())
    fs::create_directories(io::checkpoint_path(root_ / "full", 0).string() + ".partial/in the way");
  MPI_Barrier(world_.get());
  const auto parked = [](const auto& group, const auto&, const auto&, const auto&,
                         const dynamics::SampleControl& control) {
    if (group.is_root()) {
      EXPECT_THROW(control.save(std::vector<std::byte>(100)), std::runtime_error);
    }
    dynamics::SampleResult result;
    result.suspended = true;
    return result;
  };
  EXPECT_EQ(run("full", plate(1, 1), true, parked).left, 1);
  if (!world_.is_root()) return;
  EXPECT_THAT(log_.str(), HasSubstr("sample 0 suspended after"));
  EXPECT_THAT(log_.str(), HasSubstr(", but its checkpoint could not be written: cannot write '"));
}

TEST_F(EnsembleRun, ResumeComputesWhatIsMissing) {
  const auto parameters = plate(5, 1);
  run("whole", parameters, false);
  if (world_.is_root()) {
    fs::copy(root_ / "whole", root_ / "cut", fs::copy_options::recursive);
    fs::remove(root_ / "cut" / "ensemble.h5");
    fs::remove(io::sample_path(root_ / "cut", 1));
    fs::resize_file(io::sample_path(root_ / "cut", 3), fs::file_size(io::sample_path(root_ / "cut", 3)) / 2);
  }
  const auto outcome = run("cut", parameters, true, recording(strip));
  EXPECT_EQ(outcome.done, 5);
  EXPECT_THAT(computed(), ElementsAre(1, 3));
  if (!world_.is_root()) return;
  expect_same_ensemble(root_ / "whole", root_ / "cut", 5);
  EXPECT_TRUE(fs::exists(io::sample_path(root_ / "cut", 3).string() + ".invalid-1"));
  EXPECT_THAT(log_.str(), HasSubstr("0003.h5.invalid-1 and the sample computed again"));
  EXPECT_THAT(log_.str(), HasSubstr("2 of 5 samples to compute"));
}

TEST_F(EnsembleRun, StopsWhenTheMeanPathIsKnownWhateverFinishesFirst) {
  const auto parameters =
      plate(16, 1, "[ensemble.stop]\nhalf_width = \"5 mm\"\nconfidence = 0.9\nmin_samples = 4\n");
  // Early samples take longest, so that later ones end first.
  const auto slow_first = [](const auto& group, const auto&, const auto&, const auto& subdomain,
                             const auto& control) {
    std::this_thread::sleep_for(
        std::chrono::milliseconds(control.sample < 3 ? 200 - 40 * control.sample : 1));
    return break_strip(group, control.sample, subdomain);
  };
  const auto outcome = run("all", parameters, false, recording(slow_first));
  EXPECT_EQ(outcome.done, 4);
  EXPECT_EQ(outcome.failed + outcome.left, 0);
  const auto all_computed = computed();
  EXPECT_THAT(all_computed, testing::Contains(3));
  EXPECT_LT(all_computed.size(), 16u);
  const auto again = run("all", parameters, true, recording(strip));
  EXPECT_EQ(again.done, 4);
  EXPECT_EQ(again.left, 0);
  EXPECT_THAT(computed(), IsEmpty()) << "an ensemble that has stopped needs no more samples";
  if (!world_.is_root()) return;
  EXPECT_THAT(log_.str(), HasSubstr("stopped early: samples 0 to 3 suffice, 16 were planned"));
  std::printf("%zu samples computed, 4 needed\n", all_computed.size());

  const auto content = io::read_ensemble(root_ / "all" / "ensemble.h5");
  const auto statistics = analysis::make_statistics(content.samples, parameters);
  EXPECT_EQ(statistics.n_needed, 4);
  EXPECT_EQ(statistics.n_looks, 5);
  for (std::uint64_t sample = 0; sample < 16; ++sample) {
    EXPECT_EQ(content.samples[sample].status, sample < 4 ? SampleStatus::done : SampleStatus::pending);
    EXPECT_EQ(fs::exists(io::sample_path(root_ / "all", sample)), sample < 4) << sample;
  }
  run_on(parallel::Communicator(MPI_COMM_SELF), "alone", parameters, false);
  expect_same_ensemble(root_ / "all", root_ / "alone", 4);
}

TEST_F(EnsembleRun, TheEndNamesWhatIsPendingAndHowToGoOn) {
  const auto parameters = plate(5, 1);
  RunOptions options{.folder = root_ / "out",
                     .log = &log_,
                     .stop = [] { return std::optional<std::string>("asked"); },
                     .next = {.resume = "go on!", .retry_failed = "again!", .report = "pictures!"}};
  ensemble::run(world_, parameters, {}, options, strip);
  if (world_.is_root()) {
    EXPECT_THAT(log_.str(), HasSubstr("\npending: samples 0-4\n0 done, 0 failed, 5 pending after "));
    EXPECT_THAT(log_.str(), HasSubstr("\nto continue: go on!\n"));
    EXPECT_THAT(log_.str(), Not(HasSubstr("pictures!")));
  }
  options.plan.resume = true;
  options.plan.range = SampleRange{1, 3};
  log_.str("");
  ensemble::run(world_, parameters, {}, options, strip);
  if (world_.is_root()) {
    EXPECT_THAT(log_.str(), HasSubstr("\npending: samples 1-3\nsamples 1 to 3: 0 done"));
    EXPECT_THAT(log_.str(), HasSubstr("\nto continue: go on!\n"));
  }
  options.plan.range.reset();
  options.stop = {};
  log_.str("");
  ensemble::run(world_, parameters, {}, options,
                [](const auto& group, const auto&, const auto&, const auto& subdomain, const auto& control) {
                  auto result = break_strip(group, control.sample, subdomain);
                  if (control.sample % 2 == 1) throw std::runtime_error("injected");
                  return result;
                });
  if (!world_.is_root()) return;
  EXPECT_THAT(log_.str(),
              HasSubstr("\nto compute failed samples again: again!\npictures and report: pictures!\n"));
  EXPECT_THAT(log_.str(), Not(HasSubstr("go on!")));
}

TEST_F(EnsembleRun, RefusalsAreAgreedAndWriteNothing) {
  const auto parameters = plate(2, 1);
  run("out", parameters, false);
  std::map<std::string, std::string> before;
  if (world_.is_root()) before = contents(root_);
  const auto refused = [&](const std::string& name, const input::Parameters& other, bool resume) {
    try {
      run(name, other, resume);
    } catch (const parallel::AgreedError& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_THAT(refused("out", parameters, false), HasSubstr("already holds an ensemble"));
  EXPECT_THAT(refused("out", plate(1, 1), true), HasSubstr("ensemble.samples is 1, fewer than 2"));
  auto other = plate(2, 1);
  other.text.replace(other.text.find("seed = 7"), 8, "seed = 8");
  EXPECT_THAT(refused("out", input::parse(other.text, "plate.toml"), true),
              HasSubstr("ensemble.seed is 8, not 7"));
  if (world_.size() > 1) {
    EXPECT_THAT(refused("new", plate(2, 4), false), HasSubstr("needs at least 5 ranks"));
  }
  if (world_.is_root()) {
    EXPECT_EQ(contents(root_), before);
  }
}

TEST_F(EnsembleRun, FileThatCannotBeWrittenFailsItsSampleUntilItCan) {
  const auto parameters = plate(3, 1);
  const fs::path blocked = io::sample_path(root_ / "out", 1);
  const auto outcome =
      run("out", parameters, false,
          [&](const auto& group, const auto&, const auto&, const auto& subdomain, const auto& control) {
            if (control.sample == 1) fs::create_directories(blocked / "in the way");
            return break_strip(group, control.sample, subdomain);
          });
  EXPECT_EQ(outcome.done, 2);
  EXPECT_EQ(outcome.failed, 1);
  if (world_.is_root()) {
    const auto content = io::read_ensemble(root_ / "out" / "ensemble.h5");
    EXPECT_EQ(content.samples[1].status, SampleStatus::failed);
    EXPECT_THAT(content.samples[1].error, HasSubstr("writing: "));
    EXPECT_THAT(content.samples[1].error, HasSubstr("0001.h5"));
    std::printf("%s\n", content.samples[1].error.c_str());
  }
  EXPECT_EQ(run("out", parameters, true).done, 3);
}

TEST_F(EnsembleRun, VanishedFolderEndsInAReport) {
  const auto parameters = plate(1, 1);
  const auto outcome =
      run("out", parameters, false,
          [&](const auto& group, const auto&, const auto&, const auto& subdomain, const auto& control) {
            fs::remove_all(root_ / "out");
            std::ofstream(root_ / "out") << "a file in place of the folder";
            return break_strip(group, control.sample, subdomain);
          });
  EXPECT_EQ(outcome.done, 0);
  EXPECT_EQ(outcome.failed, 1);
  EXPECT_TRUE(outcome.lost);
  EXPECT_THAT(outcome.file_error, HasSubstr("lock-0-0 is gone"));
  if (world_.is_root()) {
    EXPECT_THAT(log_.str(), HasSubstr("nothing more was written"));
  }
}

TEST_F(EnsembleRun, SingleSampleIsTheOneOfTheEnsemble) {
  const auto parameters = plate(2, 1);
  run("out", parameters, false);
  EXPECT_EQ(run_single("one", parameters, {.single = 1}).done, 1);
  if (world_.is_root()) {
    EXPECT_THAT(io::differences(io::sample_path(root_ / "one", 1), io::sample_path(root_ / "out", 1)),
                IsEmpty());
    EXPECT_THAT(log_.str(), HasSubstr("worst quality"));
    EXPECT_THAT(log_.str(), HasSubstr("element updates per second"));
  } else {
    EXPECT_EQ(log_.str(), "");
  }
}

TEST_F(EnsembleRun, SingleSampleIsNotReplacedWithoutAWord) {
  const auto parameters = plate(2, 1);
  run("out", parameters, false);
  const fs::path file = io::sample_path(root_ / "out", 1);
  std::map<std::string, std::string> before;
  if (world_.is_root()) before = contents(root_);
  PlanOptions options{.single = 1};
  const auto refusal = [&]() -> std::string {
    try {
      run_single("out", parameters, options);
    } catch (const parallel::AgreedError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(refusal(), HasSubstr("0001.h5 already holds this sample; keep it with --resume, or compute it "
                                   "again with --overwrite"));
  if (world_.is_root()) {
    EXPECT_EQ(contents(root_), before);
    fs::resize_file(file, 100);
  }
  MPI_Barrier(world_.get());
  EXPECT_THAT(refusal(), HasSubstr("0001.h5 already holds this sample")) << "damaged as it is";
  options.overwrite = true;
  const auto failing = [](const auto& group, const auto&, const auto&, const auto& subdomain,
                          const auto& control) {
    break_strip(group, control.sample, subdomain);
    throw std::runtime_error("injected");
    return dynamics::SampleResult();
  };
  EXPECT_EQ(run_single("out", parameters, options, failing).failed, 1);
  options.overwrite = false;
  EXPECT_THAT(
      refusal(),
      HasSubstr("already holds this sample, as one that failed; keep it with --resume, or compute it again "
                "with --retry-failed or --overwrite"));
  options.overwrite = true;
  if (world_.is_root()) std::ofstream(io::checkpoint_path(root_ / "out", 1)) << "rubbish";
  MPI_Barrier(world_.get());
  EXPECT_EQ(run_single("out", parameters, options).done, 1);
  if (world_.is_root()) {
    EXPECT_FALSE(fs::exists(io::checkpoint_path(root_ / "out", 1)));
    run_on(parallel::Communicator(MPI_COMM_SELF), "same", parameters, false);
    EXPECT_THAT(io::differences(file, io::sample_path(root_ / "same", 1)), IsEmpty());
  }
}

TEST_F(EnsembleRun, SingleSampleThatFailsOrDoesNotExist) {
  const auto parameters = plate(2, 1);
  const auto outcome =
      run_single("one", parameters, {.single = 1},
                 [](const auto& group, const auto&, const auto&, const auto& subdomain, const auto& control) {
                   const auto result = break_strip(group, control.sample, subdomain);
                   if (group.rank() == group.size() - 1) throw std::runtime_error("injected");
                   return result;
                 });
  EXPECT_EQ(outcome.failed, 1);
  if (world_.is_root()) {
    EXPECT_EQ(outcome.rows.at(0).error, "computation: injected");
    EXPECT_EQ(io::read_summary(io::sample_path(root_ / "one", 1), parameters, 1).status,
              SampleStatus::failed);
  }
  PlanOptions again{.resume = true, .single = 1};
  EXPECT_EQ(run_single("one", parameters, again).failed, 1);
  again.retry_failed = true;
  EXPECT_EQ(run_single("one", parameters, again).done, 1);
  try {
    run_single("two", parameters, {.single = 2});
    FAIL() << "no exception";
  } catch (const parallel::AgreedError& error) {
    EXPECT_THAT(error.what(), HasSubstr("ensemble.samples = 2 has samples 0 to 1"));
  }
  EXPECT_FALSE(fs::exists(root_ / "two"));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
