// SPDX-License-Identifier: GPL-3.0-or-later
// The samples that a run computes, and the folders that it refuses.
#include "ensemble/sample_plan.h"
#include "input/reader.h"
#include "io/checkpoint_file.h"
#include "io/sample_file.h"
#include "support/temporary_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

template <class Work>
std::string message_of(Work&& work) {
  try {
    work();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

class Plan : public testing::Test {
protected:
  void SetUp() override {
    folder_ = root_ / "out";
    parameters_.text = "[ensemble]\nsamples = 5\n";
    parameters_.ensemble.samples = 5;
  }

  /// In this test sample files contain a single word.
  SummaryReader reader() const {
    return [](const fs::path& file, std::uint64_t) {
      const std::string word = text_of(file);
      analysis::SampleSummary summary;
      if (word == "done") {
        summary.status = analysis::SampleStatus::done;
      } else if (word == "failed") {
        summary.status = analysis::SampleStatus::failed;
      } else if (word != "pending") {
        throw std::runtime_error(file.filename().string() + " is truncated");
      }
      return summary;
    };
  }

  void write_sample(std::uint64_t sample, const std::string& word) const {
    write(io::sample_path(folder_, sample), word);
  }

  static PlanOptions options(bool resume) {
    PlanOptions options;
    options.resume = resume;
    return options;
  }
  SamplePlan plan(bool resume) const { return make_plan(folder_, parameters_, options(resume), reader()); }

  test::TemporaryFolder temporary_;
  fs::path root_ = temporary_.path(), folder_;
  input::Parameters parameters_;
};

TEST_F(Plan, NewFolderGetsAllSamples) {
  const auto plan = this->plan(false);
  EXPECT_THAT(plan.to_do, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(plan.kept, IsEmpty());
  EXPECT_FALSE(fs::exists(folder_)) << "a plan writes nothing";
  EXPECT_THAT(prepare_folder(folder_, parameters_, plan), IsEmpty());
  EXPECT_EQ(text_of(folder_ / "input.toml"), parameters_.text);
  EXPECT_TRUE(fs::is_directory(folder_ / "samples"));
}

TEST_F(Plan, ResumeOfANewFolderStartsIt) {
  EXPECT_THAT(plan(true).to_do, SizeIs(5));
}

TEST_F(Plan, ResumeSkipsWhatIsDoneOrFailed) {
  write(folder_ / "input.toml", parameters_.text);
  write_sample(1, "done");
  write_sample(3, "failed");
  const auto plan = this->plan(true);
  EXPECT_THAT(plan.to_do, ElementsAre(0, 2, 4));
  ASSERT_THAT(plan.kept, SizeIs(2));
  EXPECT_EQ(plan.kept[0].sample, 1u);
  EXPECT_EQ(plan.kept[0].summary.status, analysis::SampleStatus::done);
  EXPECT_EQ(plan.kept[1].sample, 3u);
  EXPECT_EQ(plan.kept[1].summary.status, analysis::SampleStatus::failed);
}

TEST_F(Plan, InvalidFilesAreNamedComputedAgainAndKeptAside) {
  write(folder_ / "input.toml", parameters_.text);
  write_sample(2, "damaged");
  write_sample(4, "pending");
  write(io::sample_path(folder_, 2).string() + ".invalid-1", "damaged earlier");
  const auto plan = this->plan(true);
  EXPECT_THAT(plan.to_do, ElementsAre(0, 1, 2, 3, 4));
  ASSERT_THAT(plan.invalid, SizeIs(2));
  EXPECT_EQ(text_of(io::sample_path(folder_, 2)), "damaged") << "a plan writes nothing";

  const auto lines = prepare_folder(folder_, parameters_, plan);
  ASSERT_THAT(lines, SizeIs(2));
  EXPECT_THAT(lines[0], HasSubstr("0002.h5 is renamed to 0002.h5.invalid-2"));
  EXPECT_THAT(lines[0], HasSubstr("0002.h5 is truncated"));
  EXPECT_THAT(lines[1], HasSubstr("0004.h5.invalid-1"));
  EXPECT_FALSE(fs::exists(io::sample_path(folder_, 2)));
  EXPECT_EQ(text_of(io::sample_path(folder_, 2).string() + ".invalid-1"), "damaged earlier");
  EXPECT_EQ(text_of(io::sample_path(folder_, 2).string() + ".invalid-2"), "damaged");
}

TEST_F(Plan, HalfWrittenFilesOfItsOwnSamplesAreRemoved) {
  const auto left_behind = [&](const std::string& name) {
    const fs::path file = folder_ / (name + ".partial");
    write(file, "half");
    return file;
  };
  const std::vector<fs::path> files{left_behind("samples/0001.h5"), left_behind("samples/0002.checkpoint"),
                                    left_behind("samples/0003.h5"), left_behind("input.toml.77")};
  const auto are_there = [&] {
    std::vector<bool> result;
    for (const auto& file : files) result.push_back(fs::exists(file));
    return result;
  };
  auto part = options(true);
  part.range = SampleRange{1, 2};
  prepare_folder(folder_, parameters_, make_plan(folder_, parameters_, part, reader()));
  EXPECT_THAT(are_there(), ElementsAre(false, false, true, true)) << "another run may be writing those";
  prepare_folder(folder_, parameters_, plan(true));
  EXPECT_THAT(are_there(), ElementsAre(false, false, false, false));
}

TEST_F(Plan, FailedSamplesThatAreTriedAgainBeginAnew) {
  write(folder_ / "input.toml", parameters_.text);
  write_sample(1, "failed");
  write_sample(3, "failed");
  const fs::path checkpoint = io::checkpoint_path(folder_, 1);
  write(checkpoint, "on the way to the failure");
  auto retry = options(true);
  retry.retry_failed = true;
  const auto plan = make_plan(folder_, parameters_, retry, reader());
  EXPECT_THAT(plan.to_do, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(plan.anew, ElementsAre(1, 3));
  EXPECT_THAT(plan.suspended, IsEmpty());
  EXPECT_THAT(plan.invalid, IsEmpty());
  EXPECT_TRUE(fs::exists(checkpoint)) << "a plan writes nothing";
  prepare_folder(folder_, parameters_, plan);
  EXPECT_FALSE(fs::exists(checkpoint));
  // Samples suspended from now on are continued by --resume.
  EXPECT_THAT(this->plan(true).to_do, ElementsAre(0, 1, 2, 3, 4));
}

TEST_F(Plan, HalfWrittenResultsBelongToTheirWriter) {
  const fs::path partial = folder_ / "ensemble.h5.host-12.partial";
  write(partial, "half");
  prepare_folder(folder_, parameters_, plan(true));
  EXPECT_TRUE(fs::exists(partial));
}

TEST(PartOfSamples, PartsMakeUpTheEnsemble) {
  for (const std::uint64_t n_samples : {1, 7, 200}) {
    for (std::uint64_t n_parts = 1; n_parts <= n_samples; ++n_parts) {
      std::uint64_t next = 0;
      for (std::uint64_t number = 0; number < n_parts; ++number) {
        const auto [first, last] = part_of_samples(number, n_parts, n_samples);
        EXPECT_EQ(first, next);
        EXPECT_GE(last + 1 - first, n_samples / n_parts);
        EXPECT_LE(last + 1 - first, n_samples / n_parts + 1);
        next = last + 1;
      }
      EXPECT_EQ(next, n_samples);
    }
  }
  EXPECT_THAT(message_of([] { part_of_samples(0, 8, 7); }),
              HasSubstr("8 parts are more than ensemble.samples = 7"));
}

TEST_F(Plan, FolderWithAnEnsembleIsRefusedWithoutResume) {
  for (const char* name : {"input.toml", "ensemble.h5", "samples/0003.h5"}) {
    fs::remove_all(folder_);
    write(folder_ / name, parameters_.text);
    EXPECT_THAT(message_of([&] { plan(false); }), HasSubstr("out already holds an ensemble")) << name;
  }
  fs::remove_all(folder_);
  fs::create_directories(folder_ / "samples");
  EXPECT_THAT(plan(false).to_do, SizeIs(5)) << "empty folders hold nothing";
}

TEST_F(Plan, FileInPlaceOfTheFolderIsRefused) {
  write(folder_, "something else");
  for (const bool resume : {false, true}) {
    EXPECT_THAT(message_of([&] { plan(resume); }), HasSubstr("out is not a folder"));
  }
  EXPECT_EQ(text_of(folder_), "something else");
}

TEST_F(Plan, ResumeWithAnotherInputIsRefusedWithTheDifference) {
  write(folder_ / "input.toml", "[ensemble]\nsamples = 8\n");
  const auto message = message_of([&] { plan(true); });
  EXPECT_THAT(message, HasSubstr("line 2 is 'samples = 5', not 'samples = 8'"));
  EXPECT_THAT(message, HasSubstr((folder_ / "input.toml").string()));
}

TEST_F(Plan, ResumeWithOtherSectionsOrFramesIsToldWhatIsPossible) {
  const std::string plate = text_of(fs::path(CRACKLE_SOURCE_DIR) / "tests/support/plate.toml");
  write(folder_ / "input.toml", plate);
  const auto changed = [&](const std::vector<std::pair<std::string, std::string>>& changes) {
    std::string text = plate;
    for (const auto& [from, to] : changes) {
      const auto at = text.find(from);
      if (at == std::string::npos) throw std::logic_error(from);
      text.replace(at, from.size(), to);
    }
    const auto parameters = input::parse(text, "plate.toml");
    return message_of([&] { make_plan(folder_, parameters, options(true), reader()); });
  };
  const std::pair<std::string, std::string> sections{R"(["3 mm", "4 mm"])", R"(["3 mm", "5 mm"])"};
  const std::pair<std::string, std::string> frames{"frames = 4", "frames = 9"};
  const std::string of_another = folder_.string() + " holds an ensemble of another input: compared with " +
                                 (folder_ / "input.toml").string() + ", ";
  const std::string look =
      "use other sections later, with crackle stats " + folder_.string() + " --sections y=\"3 mm, 5 mm\"";
  EXPECT_EQ(changed({}), "");
  EXPECT_EQ(changed({sections}), of_another +
                                     "sections.y is [3 mm, 5 mm], not [3 mm, 4 mm]; keep the "
                                     "sections of the folder, or use another folder; " +
                                     look);
  EXPECT_EQ(changed({frames}), of_another +
                                   "output.frames is 9, not 4; keep the output of the folder, or use "
                                   "another folder; what is recorded cannot be changed afterwards");
  EXPECT_EQ(changed({sections, frames}),
            of_another +
                "output.frames is 9, not 4, sections.y is [3 mm, 5 mm], not [3 mm, 4 mm]; keep the "
                "sections and output of the folder, or use another folder; " +
                look + "; what is recorded cannot be changed afterwards");
  EXPECT_EQ(changed({sections, {"seed = 1", "seed = 2"}}),
            of_another +
                "ensemble.seed is 2, not 1, sections.y is [3 mm, 5 mm], not [3 mm, 4 mm]; use that input, "
                "or another folder");
  EXPECT_EQ(
      changed({{"y = [\"3 mm\", \"4 mm\"]",
                "y = [\"3 mm\", \"4 mm\"]\n[[sections.line]]\nfrom = [\"1 mm\", \"2 mm\"]\nto = [\"3 mm\", "
                "\"4 mm\"]"}}),
      of_another +
          "sections.line[0].from is [1 mm, 2 mm], not absent, sections.line[0].to is [3 mm, 4 mm], not "
          "absent; keep the sections of the folder, or use another folder; use other sections later, "
          "with crackle stats " +
          folder_.string() + " --sections y=\"3 mm, 4 mm\" --sections line=\"1 mm, 2 mm; 3 mm, 4 mm\"");
  // Settings that are not sections of the other input yield no sections to show.
  EXPECT_EQ(
      changed({{"face = \"y-min\"", "face = \"z-min\""}, {"y = [\"3 mm\", \"4 mm\"]", "z = [\"3 mm\"]"}}),
      of_another +
          "sections.y is absent, not [3 mm, 4 mm], sections.z is [3 mm], not absent, "
          "specimen.notch[0].face is z-min, not y-min; use that input, or another folder");
  std::string many = "y = [\"3 mm\"";
  for (int i = 0; i < 60; ++i) many += fmt::format(", \"{} mm\"", 3.01 + 0.01 * i);
  EXPECT_EQ(changed({{"y = [\"3 mm\", \"4 mm\"]", many + "]"}, {"seed = 1", "seed = 2"}}),
            of_another + "ensemble.seed is 2, not 1, sections.y differs; use that input, or another folder");
}

TEST_F(Plan, ResumeWithOtherPointsIsRefusedWithTheDifference) {
  const fs::path cloud = root_ / "cloud.txt";
  write(cloud, "0 0 0\n1 0 0\n");
  parameters_.mesh.points = cloud;
  prepare_folder(folder_, parameters_, plan(false));
  EXPECT_EQ(text_of(points_copy(folder_)), "0 0 0\n1 0 0\n");
  EXPECT_THAT(plan(true).to_do, SizeIs(5));
  write(cloud, "0 0 0\n1 0 0.5\n");
  const auto message = message_of([&] { plan(true); });
  EXPECT_THAT(message, HasSubstr("line 2 is '1 0 0.5', not '1 0 0'"));
  EXPECT_THAT(message, HasSubstr(points_copy(folder_).string()));
}

TEST_F(Plan, FolderThatCannotBeMadeIsNamed) {
  write(root_ / "file", "");
  folder_ = root_ / "file" / "out";
  EXPECT_THAT(message_of([&] { prepare_folder(folder_, parameters_, plan(false)); }),
              HasSubstr("cannot make the folder '"));
}

TEST(FirstDifference, NamesLineAndTexts) {
  EXPECT_FALSE(first_difference("a\nb\n", "a\nb\n"));
  EXPECT_EQ(first_difference("a\nb\n", "a\nc\n"), "line 2 is 'c', not 'b'");
  EXPECT_EQ(first_difference("a\nb\n", "a\n"), "line 2 is missing, not 'b'");
  EXPECT_EQ(first_difference("a\n", "a\nb\n"), "line 2 is 'b', not missing");
  EXPECT_EQ(first_difference("a\n", "a"), "the last line's end");
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
