// SPDX-License-Identifier: GPL-3.0-or-later
// Reading experiments: good files, and every error of bad ones.
#include "crackle/experiment/experiments_file.h"
#include "crackle/input/reader.h"

#include "support/temporary_folder.h"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

namespace crackle::experiment {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class ExperimentsFile : public ::testing::Test {
protected:
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
  }
  std::vector<Experiment> read(const std::string& text) {
    write("experiments.toml", text);
    return read_experiments(folder_.path() / "experiments.toml");
  }
  /// Messages without the folder.
  std::vector<std::string> errors(const std::string& text) {
    try {
      read(text);
    } catch (const input::InputError& error) {
      std::vector<std::string> messages = error.messages();
      const std::string prefix = folder_.path().string() + "/";
      for (std::string& message : messages)
        for (auto at = message.find(prefix); at != std::string::npos; at = message.find(prefix))
          message.erase(at, prefix.size());
      return messages;
    }
    return {};
  }
  std::string one_error(const std::string& text) {
    const auto all = errors(text);
    EXPECT_THAT(all, SizeIs(1));
    return all.empty() ? "" : all[0];
  }

  test::TemporaryFolder folder_;
};

TEST_F(ExperimentsFile, HasAllThatWasObserved) {
  write("path.csv", "# a comment\ny_mm,z_mm\n1,2\n2,2\n# another\n4,2\n\n3,3\r\n5,6\n");
  write("tips.csv", "time_us;y_cm;z_cm\n10;0.1;0.2\n20;0.2;0.2\n");
  write("curve.csv", "displacement_um\tload_kN\n0\t0\n5\t0.3\n6\t0.1\n");
  for (const char* picture : {"frame.png", "frame.jpg"}) write(picture, "");
  const auto experiments = read(R"(
[[experiment]]
name = "first"
path = "path.csv"
path_error = "0.1 mm"
arrested = true
origin = ["10 mm", "20 mm"]
angle = "90 degree"
mirror = "y"
onset_load = "0.2 kN"
load_error = "3 N"
tips = "tips.csv"
time_error = "1 us"
curve = "curve.csv"
[[experiment.tip]]
time = "30 us"
at = ["4 mm", "2 mm"]
[[experiment.picture]]
file = "frame.png"
time = "30 us"
scale = "0.05 mm"
origin = [12, 34.5]
[[experiment.picture]]
file = "frame.jpg"
time = "40 us"
scale = "50 um"
origin = [0, 0]
field = "light"
reversed = true
[[experiment]]
name = "second"
peak_load = "7 N"
)");
  ASSERT_THAT(experiments, SizeIs(2));
  const Experiment& first = experiments[0];
  EXPECT_EQ(first.name, "first");
  ASSERT_THAT(first.lines, SizeIs(2));
  ASSERT_THAT(first.lines[0], SizeIs(3));
  // (1, 2), reversed in y: (-1, 2); turned by 90 degrees: (-2, -1).
  EXPECT_THAT(first.lines[0][0], ElementsAre(DoubleNear(8e-3, 1e-15), DoubleNear(19e-3, 1e-15)));
  EXPECT_THAT(first.lines[1][1], ElementsAre(DoubleNear(4e-3, 1e-15), DoubleNear(15e-3, 1e-15)));
  EXPECT_DOUBLE_EQ(first.path_error, 1e-4);
  EXPECT_NEAR(first.path_error_length, 1.5e-3, 1e-12) << "the mean distance of its points";
  EXPECT_TRUE(first.is_arrested);
  EXPECT_DOUBLE_EQ(first.onset_load.value(), 200);
  EXPECT_DOUBLE_EQ(first.peak_load.value(), 300) << "of the curve";
  EXPECT_DOUBLE_EQ(first.load_error, 3);
  ASSERT_THAT(first.tips, SizeIs(3));
  EXPECT_NEAR(first.tips[0].time, 30e-6, 1e-18);
  EXPECT_NEAR(first.tips[1].time, 10e-6, 1e-18);
  EXPECT_THAT(first.tips[0].at, ElementsAre(DoubleNear(8e-3, 1e-15), DoubleNear(16e-3, 1e-15)));
  EXPECT_DOUBLE_EQ(first.time_error, 1e-6);
  EXPECT_NEAR(first.curve.displacement[2], 6e-6, 1e-18);
  ASSERT_THAT(first.pictures, SizeIs(2));
  EXPECT_TRUE(first.pictures[0].has_dark_field);
  EXPECT_FALSE(first.pictures[0].is_reversed);
  EXPECT_THAT(first.pictures[0].origin, ElementsAre(12, 34.5));
  EXPECT_THAT(first.pictures[0].corner, ElementsAre(DoubleNear(8.275e-3, 1e-15), DoubleNear(20.6e-3, 1e-15)));
  EXPECT_THAT(first.pictures[0].right, ElementsAre(DoubleNear(0, 1e-15), DoubleNear(-0.05e-3, 1e-15)));
  EXPECT_THAT(first.pictures[0].down, ElementsAre(DoubleNear(0.05e-3, 1e-15), DoubleNear(0, 1e-15)));
  EXPECT_FALSE(first.pictures[1].has_dark_field);
  EXPECT_TRUE(first.pictures[1].is_reversed);
  EXPECT_DOUBLE_EQ(first.pictures[1].scale, 50e-6);
  EXPECT_DOUBLE_EQ(experiments[1].peak_load.value(), 7);
}

TEST_F(ExperimentsFile, ArmsCanBeAColumn) {
  write("path.csv", "arm,y_m,z_m\nmain,1,1\nupper,1,2\nmain,2,1\nupper,2,3\nmain,3,1\n");
  const auto experiments = read("[[experiment]]\nname = \"a\"\npath = \"path.csv\"\n");
  ASSERT_THAT(experiments.at(0).lines, SizeIs(2));
  EXPECT_THAT(experiments[0].lines[0], ElementsAre(ElementsAre(1, 1), ElementsAre(2, 1), ElementsAre(3, 1)));
}

TEST_F(ExperimentsFile, LoadsAloneAreExperiments) {
  write("loads.csv", "peak_load_N\n120\n130.5\n");
  const auto top = read("loads = \"loads.csv\"\nload_error = \"1 N\"\n");
  ASSERT_THAT(top, SizeIs(2));
  EXPECT_EQ(top[1].name, "row 2");
  EXPECT_DOUBLE_EQ(top[1].peak_load.value(), 130.5);
  EXPECT_DOUBLE_EQ(top[1].load_error, 1);
  write("strengths.csv", "name,strength_MPa\nA1,300\nA2,310\n");
  const auto table = read(
      "loads = \"loads.csv\"\n[[experiment]]\nname = \"alumina\"\nloads = \"strengths.csv\"\n"
      "load_per_strength = \"0.5 mm^2\"\n[[experiment]]\nname = \"one\"\nonset_load = \"3 N\"\n");
  ASSERT_THAT(table, SizeIs(5));
  EXPECT_EQ(table[3].name, "alumina A2");
  EXPECT_NEAR(table[3].peak_load.value(), 155, 1e-9);
}

TEST_F(ExperimentsFile, NamesInLoadsAreOneShortLine) {
  write("loads.csv", "name,peak_load_N\nA\x1b[31m,120\n" + std::string(5000, 'B') + ",130\n");
  const auto rows = read("loads = \"loads.csv\"\n");
  ASSERT_THAT(rows, SizeIs(2));
  EXPECT_EQ(rows[0].name, "A?[31m");
  EXPECT_EQ(rows[1].name, std::string(60, 'B') + "...");
}

TEST_F(ExperimentsFile, AllErrorsAreReportedAtOnce) {
  write("path.csv", "y_mm,z_kg\n1,2\n");
  write("tips.csv", "time_us,y_mm,z_mm\n1,2\nx,2,3\n");
  EXPECT_THAT(
      errors("[[experiment]]\nname = \"a\"\npath = \"path.csv\"\ntips = \"tips.csv\"\nonset_load = \"3 mm\"\n"
             "typo = 3\n[[experiment]]\nname = \"b\"\n"),
      ElementsAre("experiments.toml:3: experiment[0].path: path.csv: the heading \"z_kg\" does not end in a "
                  "unit of a "
                  "length; write such as \"z_mm\"",
                  "experiments.toml:4: experiment[0].tips: tips.csv: line 2: has 2 values under 3 headings",
                  AllOf(HasSubstr("experiments.toml:5: experiment[0].onset_load: "), HasSubstr("a force")),
                  AllOf(HasSubstr("experiments.toml:6: experiment[0].typo: unknown key; "),
                        HasSubstr("did you mean tips?")),
                  AllOf(HasSubstr("experiments.toml:7: experiment[1]: nothing was observed"),
                        HasSubstr("give path, "))));
}

TEST_F(ExperimentsFile, ErrorsOfCsvFiles) {
  const auto error = [&](const std::string& csv) {
    write("path.csv", csv);
    return one_error("[[experiment]]\nname = \"a\"\npath = \"path.csv\"\n");
  };
  EXPECT_THAT(one_error("[[experiment]]\nname = \"a\"\npath = \"none.csv\"\n"),
              EndsWith("there is no such file"));
  EXPECT_THAT(one_error("[[experiment]]\nname = \"a\"\npath = \".\"\n"), EndsWith("is a folder"));
  EXPECT_THAT(error(""), EndsWith("is empty"));
  EXPECT_THAT(error("y_mm,z_mm\n1,2\n1;3,4\n"),
              EndsWith("line 3: \"1;3\" is not a number; write such as 12.5"));
  EXPECT_THAT(error("y_mm,z_mm\n1,2\n1,nan\n"), HasSubstr("line 3: \"nan\""));
  EXPECT_THAT(error("y_mm\n1\n2\n"), EndsWith("has no column z; give a header such as y_mm,z_mm"));
  EXPECT_THAT(error("y,z_mm\n1,2\n2,3\n"), HasSubstr("the heading \"y\" does not end in a unit"));
  EXPECT_THAT(error("y_mm,z_mm\n1,2\n"), EndsWith("has 1 row; give at least 2"));
  EXPECT_THAT(error("y_mm,z_mm,y_mm\n1,2,3\n2,3,4\n"),
              EndsWith("line 1: two columns are called \"y_mm\"; leave one of them out"));
  EXPECT_THAT(error(std::string("\xff\xfey\0_\0m\0m\0,\0z\0_\0m\0m\0\n\0", 24)),
              EndsWith("line 1: not text in UTF-8, but perhaps in UTF-16; save the file as CSV in UTF-8"));
  EXPECT_THAT(error("y_mm,z_mm\n1,2\n\x1b[2J,4\n"), HasSubstr("\"?[2J\" is not a number"));
  EXPECT_THAT(error("y_mm,z_mm\n1,2\n2,3\n\n5,6\n"), HasSubstr("arm 2 has a single point"));
}

TEST_F(ExperimentsFile, ErrorsOfPictures) {
  const auto error = [&](const std::string& file) {
    return one_error("[[experiment]]\nname = \"a\"\n[[experiment.picture]]\nfile = \"" + file +
                     "\"\ntime = \"0 s\"\nscale = \"1 mm\"\norigin = [0, 0]\n");
  };
  EXPECT_THAT(error("none.png"), HasSubstr("experiment[0].picture[0].file: none.png: there is no such file"));
  EXPECT_THAT(error("."), HasSubstr(": is a folder; give the name of a PNG or JPEG file"));
  EXPECT_THAT(errors("[[experiment]]\nname = \"a\"\n[[experiment.picture]]\nfield = \"grey\"\n"),
              ElementsAre(HasSubstr("picture[0].file: the key is missing"),
                          HasSubstr("picture[0].time: the key is missing"),
                          HasSubstr("picture[0].scale: the key is missing"),
                          HasSubstr("picture[0].origin: the key is missing"),
                          HasSubstr("\"grey\" is not known; give \"light\" or \"dark\"")));
}

TEST_F(ExperimentsFile, ErrorsOfLoads) {
  const auto error = [&](const std::string& csv) {
    write("loads.csv", csv);
    return one_error("loads = \"loads.csv\"\n");
  };
  EXPECT_THAT(error("load_N\n3\n"), EndsWith("give a header such as peak_load_N"));
  EXPECT_THAT(error("strength_MPa\n3\n"), HasSubstr("give load_per_strength too"));
  EXPECT_THAT(error("strength_MPa,peak_load_N\n3,3\n"), HasSubstr("leave one of them out"));
  EXPECT_THAT(error("peak_load_N\n"), EndsWith("has no rows"));
  EXPECT_THAT(error("peak_load_N\n3\n-3\n"),
              EndsWith("line 3: negative load; loads are positive in the machine's direction"));
  EXPECT_THAT(one_error("load_error = \"3 N\"\n[[experiment]]\nname = \"a\"\npeak_load = \"3 N\"\n"),
              HasSubstr("load_error: is for loads"));
  write("loads.csv", "peak_load_N\n3\n");
  EXPECT_THAT(one_error("[[experiment]]\nloads = \"loads.csv\"\npeak_load = \"3 N\"\n"),
              HasSubstr("experiment[0].peak_load: does not go with loads"));
}

TEST_F(ExperimentsFile, OtherErrors) {
  EXPECT_THAT(one_error("# nothing\n"), HasSubstr("there is no experiment"));
  EXPECT_THAT(one_error("[[experiment]]\npeak_load = \"3 N\"\n"),
              HasSubstr("experiment[0].name: the key is missing"));
  EXPECT_THAT(one_error("[experiment]\npeak_load = \"3 N\"\n"),
              HasSubstr("write [[experiment]], in double brackets"));
  EXPECT_THAT(one_error("[[experiment]\n"), HasSubstr("syntax error"));
  EXPECT_THAT(
      one_error(
          "[[experiment]]\nname = \"a\"\npeak_load = \"3 N\"\n[[experiment]]\nname = \"a\"\npeak_load = "
          "\"3 N\"\n"),
      HasSubstr("two experiments are named \"a\""));
  EXPECT_THAT(
      errors(
          "[[experiment]]\nname = \"a\"\npeak_load = \"3 N\"\npath_error = \"1 mm\"\ntime_error = \"1 s\"\n"),
      ElementsAre(HasSubstr("path_error: is for path"), HasSubstr("time_error: is for tip or tips")));
  EXPECT_THAT(errors("[[experiment]]\nname = \"a\"\n[[experiment.tip]]\ntime = \"1 us\"\n"),
              ElementsAre(HasSubstr("experiment[0].tip[0].at: the key is missing; give two lengths")));
  EXPECT_THAT(errors("[[experiment]]\nname = \"a\"\npeak_load = \"3 N\"\narrested = 1\n"),
              ElementsAre(HasSubstr("give true or false"), HasSubstr("arrested: is for path")));
  EXPECT_THAT(one_error("[[experiment]]\nname = \"a\"\nonset_load = \"-3 N\"\n"), HasSubstr("onset_load: "));
  EXPECT_THAT(one_error("[[experiment]]\nname = \"a\"\n[[experiment.tip]]\ntime = \"-1 us\"\nat = [\"1 mm\", "
                        "\"2 mm\"]\n"),
              HasSubstr("tip[0].time: "));
  write("tips.csv", "time_us,y_mm,z_mm\n-1,2,3\n");
  EXPECT_THAT(one_error("[[experiment]]\nname = \"a\"\ntips = \"tips.csv\"\n"),
              EndsWith("line 2: the time is below 0; times count from when the crack began to run"));
  write("curve.csv", "displacement_mm,load_N\n0,-1\n1,-3\n");
  EXPECT_THAT(one_error("[[experiment]]\nname = \"a\"\ncurve = \"curve.csv\"\n"),
              EndsWith("all loads are below 0; they count along the machine's drive"));
  EXPECT_THROW(read_experiments(folder_.path() / "none.toml"), input::InputError);
}

TEST_F(ExperimentsFile, ThePageNamesEveryKey) {
  std::ifstream file(std::filesystem::path(CRACKLE_SOURCE_DIR) / "jobs/experiments.md");
  const std::string page((std::istreambuf_iterator<char>(file)), {});
  for (const std::string& key : experiment_keys())
    EXPECT_THAT(page, HasSubstr("`" + key.substr(key.rfind('.') + 1) + "`")) << key;
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::experiment
