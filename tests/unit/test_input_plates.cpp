// SPDX-License-Identifier: GPL-3.0-or-later
// Inputs of plates with any outline.
#include "input/consistency.h"
#include "input_samples.h"
#include "support/plate_family.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>

#include <fstream>
#include <numbers>

namespace crackle::input {
namespace CRACKLE_TEST_FILE {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

test::PlateText square() {
  return {R"(thickness = "2 mm"
outline = [["-5 mm", "1 mm"], ["15 mm", "1 mm"], ["15 mm", "21 mm"], ["-5 mm", "21 mm"]])"};
}

TEST(InputPlates, Values) {
  test::PlateText plate = square();
  plate.holes = {R"(center = ["5 mm", "8 mm"]
semi_axes = ["2 mm", "1 mm"]
angle = "30 degree")"};
  plate.notches = {R"(from = ["-5 mm", "15 mm"]
to = ["3 mm", "15 mm"]
height = "0.5 mm"
end = "round")"};
  const Parameters p = parse(plate.text(), "plate.toml");
  EXPECT_THAT(p.specimen.size, ElementsAre(2e-3, DoubleNear(20e-3, 1e-15), DoubleNear(20e-3, 1e-15)));
  EXPECT_DOUBLE_EQ(bounds_of(p.specimen)[1].first, -5e-3);
  EXPECT_NEAR(p.specimen.holes.at(0).angle, std::numbers::pi / 6, 1e-15);
  ASSERT_TRUE(p.specimen.notches.at(0).slot);
  EXPECT_EQ(p.specimen.notches[0].slot->end, plane::SlotEnd::round);
  ASSERT_TRUE(p.specimen.shape);
  EXPECT_EQ(p.specimen.shape->loops.size(), 2u);
  const std::string text = echo(p);
  for (const char* line : {"= [[-5 mm, 1 mm], [15 mm, 1 mm], [15 mm, 21 mm], [-5 mm, 21 mm]]",
                           "= [2 mm, 1 mm]", "= 30 degree", "= [3 mm, 15 mm]", "= round"})
    EXPECT_THAT(text, HasSubstr(line));
  EXPECT_THAT(text, Not(HasSubstr("specimen.size")));
}

TEST(InputPlates, ASlotInAFaceLiesAtAnyCoordinateOfTheBody) {
  const auto errors = [](const char* at) {
    test::PlateText plate = square();
    plate.notches = {fmt::format("face = \"z-min\"\nat = \"{}\"\ndepth = \"3 mm\"\nheight = \"0.5 mm\"", at)};
    return test::errors_of(plate.text());
  };
  for (const char* at : {"-4 mm", "0 mm", "3 mm"}) EXPECT_THAT(errors(at), testing::IsEmpty()) << at;
  EXPECT_EQ(errors("-7 mm").size(), 1u);
}

/// The slot reaches from y = -5 to 0 mm.
TEST(InputPlates, LigamentsBeginWhereTheBodyDoes) {
  test::PlateText plate = square();
  plate.notches = {"face = \"y-min\"\nat = \"5 mm\"\ndepth = \"5 mm\"\nheight = \"0.5 mm\""};
  const auto warnings = [&](const char* section) {
    plate.section = section;
    return section_warnings(parse(plate.text(), "plate.toml"));
  };
  EXPECT_THAT(warnings("2 mm"), testing::IsEmpty());
  EXPECT_THAT(warnings("-2 mm"), ElementsAre(HasSubstr("ligaments between 0 and 15 mm")));
}

TEST(InputPlates, EveryKeyIsPartOfTheIdentity) {
  const std::string base = sample_identity(parse(square().text(), "plate.toml"));
  test::PlateText other = square();
  other.specimen.replace(other.specimen.find("21 mm"), 5, "22 mm");
  EXPECT_NE(sample_identity(parse(other.text(), "plate.toml")), base);
  std::vector<std::string> identities{base};
  for (const char* end : {"square", "round"})
    for (const char* height : {"1 mm", "2 mm"}) {
      test::PlateText notched = square();
      notched.notches = {
          fmt::format("from = [\"2 mm\", \"5 mm\"]\nto = [\"9 mm\", \"5 mm\"]\nheight = \"{}\"\nend = \"{}\"",
                      height, end)};
      const std::string identity = sample_identity(parse(notched.text(), "plate.toml"));
      EXPECT_EQ(std::ranges::count(identities, identity), 0);
      identities.push_back(identity);
    }
}

// The text stored in result files needs no other file.
TEST(InputPlates, OutlineFromAFileBecomesPartOfTheText) {
  const test::TemporaryFolder folder;
  const auto write = [&](const std::string& text) { std::ofstream(folder.path() / "edge.txt") << text; };
  const auto read_with = [&](const std::string& name) {
    test::PlateText plate = square();
    plate.specimen = "thickness = \"2 mm\"\noutline = " + name + " # from a drawing";
    return parse(plate.text(), folder.path() / "plate.toml");
  };
  write("# y z\n-5 1\n15, 1\n\n15 21 # upper right\n-5 21\n");
  const Parameters given = parse(square().text(), "plate.toml");
  const Parameters read = read_with("\"edge.txt\"");
  EXPECT_EQ(read.specimen.outline->polygon, given.specimen.outline->polygon);
  EXPECT_EQ(sample_identity(read), sample_identity(given));
  EXPECT_THAT(read.text, Not(HasSubstr("edge.txt")));
  EXPECT_THAT(read.text, HasSubstr("# from a drawing"));
  std::filesystem::remove(folder.path() / "edge.txt");
  const Parameters again = parse(read.text, "elsewhere.toml");
  EXPECT_EQ(again.specimen.outline->polygon, given.specimen.outline->polygon);
  EXPECT_EQ(again.text, read.text);

  const auto error = [&](const std::string& text) -> std::string {
    write(text);
    try {
      read_with("'edge.txt'");
    } catch (const InputError& refusal) {
      return refusal.what();
    }
    return "";
  };
  EXPECT_THAT(error("0 0\n1 2 3\n"), HasSubstr("edge.txt:2: not a point"));
  EXPECT_THAT(error("0 0\n1 x\n"), HasSubstr("edge.txt:2: not a point"));
  EXPECT_THAT(error("0 0\n1 1\n"), HasSubstr("2 points cannot enclose an area"));
  EXPECT_THAT(error("0 0\n1 1e9\n1 0\n"), HasSubstr("edge.txt:2: is out of range"));
  EXPECT_THAT(error(""), HasSubstr("0 points cannot enclose an area"));
  EXPECT_EQ(error("0 0\r\n20 0\r\n20 20\r\n"), "");
}

// Conditions that hold the same wall twice, under any of its names.
TEST(InputPlates, ConflictsAreFoundByWall) {
  const auto errors = [](const std::string& first, const std::string& second) {
    std::string text = square().text();
    const std::size_t at = text.find("[time]");
    return test::errors_of(
        text.insert(at, fmt::format("[[boundary]]\n{}\ndisplacement = [\"free\", \"free\", \"1 "
                                    "mm\"]\n[[boundary]]\n{}\ndisplacement = "
                                    "[\"free\", \"free\", \"2 mm\"]\n",
                                    first, second)));
  };
  EXPECT_EQ(errors("on = \"edge-0\"", "on = \"edge-2\"").size(), 0u);
  EXPECT_EQ(errors("on = \"edge-2\"", "on = \"z-max\"").size(), 1u);
  EXPECT_EQ(errors("on = \"edge-2\"\nregion = { y = [\"-5 mm\", \"4 mm\"] }",
                   "on = \"z-max\"\nregion = { y = [\"5 mm\", \"15 mm\"] }")
                .size(),
            0u);
  EXPECT_EQ(errors("on = \"edge-2\"\nregion = { y = [\"-5 mm\", \"6 mm\"] }",
                   "on = \"z-max\"\nregion = { y = [\"5 mm\", \"15 mm\"] }")
                .size(),
            1u);
  // Regions with a common border have no common part of the wall.
  EXPECT_EQ(errors("on = \"edge-2\"\nregion = { y = [\"-5 mm\", \"5 mm\"] }",
                   "on = \"z-max\"\nregion = { y = [\"5 mm\", \"15 mm\"] }")
                .size(),
            0u);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::input
