// SPDX-License-Identifier: GPL-3.0-or-later
// Replacing values in the text of an input, and the cases of a sweep.
#include "input/reader.h"

#include "input_samples.h"

#include <gmock/gmock.h>

namespace crackle::input {
namespace CRACKLE_TEST_FILE {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string text = R"(# A plate.
[ensemble]
samples = 3
[specimen]
size = ["5 mm", "24.5 mm", "140 mm"] # as in the paper
[[specimen.notch]]
face = "y-min"
at = "65 mm"
depth = "6 mm"
height = "0.6 mm"
[[specimen.notch]]
face = "y-max"
at = "75 mm"
depth = "6 mm" # likewise
height = "0.6 mm"
[mesh]
spacing = "3 mm"
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.38
density = "1180 kg/m^3"
[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "135 N"]
rate = ["0 N/s",
        "0 N/s", "5 N/s"]
[time]
duration = "140 us"
[sections]
y = ["7 mm", "9 mm"])";

TEST(Settings, ReplaceValuesWhereTheyStand) {
  const std::string changed = with_settings(text, {{"specimen.notch[1].depth", "\"5 mm\""},
                                                   {"boundary[1].rate[2]", "\"7 N/s\""},
                                                   {"specimen.size[0]", "\"4 mm\""},
                                                   {"material.poisson_ratio", "0.25"}});
  EXPECT_THAT(changed, HasSubstr("depth = \"6 mm\"\nheight"));
  EXPECT_THAT(changed, HasSubstr("depth = \"5 mm\" # likewise"));
  EXPECT_THAT(changed, HasSubstr("        \"0 N/s\", \"7 N/s\"]"));
  EXPECT_THAT(changed, HasSubstr("size = [\"4 mm\", \"24.5 mm\", \"140 mm\"] # as in the paper"));
  const Parameters parameters = parse(changed, "plate.toml");
  EXPECT_EQ(parameters.materials[0].poisson_ratio, 0.25);
  EXPECT_EQ(parameters.boundaries[1].rate[2], 7);
  EXPECT_THAT(parameters.specimen.notches, ElementsAre(::testing::Field(&plane::Notch::depth, 6e-3),
                                                       ::testing::Field(&plane::Notch::depth, 5e-3)));
}

TEST(Settings, AddKeysThatAreNotThere) {
  const std::string changed = with_settings(text, {{"mesh.perturbation", "0.1"},
                                                   {"boundary[0].region.x", "[\"0 mm\", \"1 mm\"]"},
                                                   {"output.frames", "3"},
                                                   {"fracture.release", "\"facet\""}});
  EXPECT_THAT(changed, HasSubstr("[mesh]\nperturbation = 0.1\n"));
  EXPECT_THAT(changed, HasSubstr("[[boundary]]\nregion.x = [\"0 mm\", \"1 mm\"]\non = \"z-min\"\n"));
  const Parameters parameters = parse(changed, "plate.toml");
  EXPECT_EQ(parameters.mesh.perturbation, 0.1);
  EXPECT_EQ(parameters.boundaries[0].region[0].second, 1e-3);
  EXPECT_EQ(parameters.output.frames, 3);
  EXPECT_EQ(parameters.fracture.release, Release::facet);
}

TEST(Settings, AddKeysInTheFormOfTheTable) {
  const std::string changed = with_settings(
      "specimen.size = [\"3 mm\", \"30 mm\", \"60 mm\"]\n"
      "mesh = { spacing = \"1 mm\" }\n"
      "damping = {}\n"
      "boundary = [{ on = \"z-min\" }, { on = \"z-max\", region.y = [\"1 mm\", \"2 mm\"] }]\n"
      "time.duration = \"20 us\"  # long\n"
      "[fracture]\n"
      "variation.modulus = 10\n",
      {{"mesh.perturbation", "0.1"},
       {"damping.mass", "\"5 1/s\""},
       {"boundary[1].region.x", "[\"0 mm\", \"1 mm\"]"},
       {"time.integrator", "\"verlet\""},
       {"fracture.variation.of", "\"both\""},
       {"output.frames", "3"}});
  EXPECT_EQ(changed,
            "specimen.size = [\"3 mm\", \"30 mm\", \"60 mm\"]\n"
            "mesh = { perturbation = 0.1, spacing = \"1 mm\" }\n"
            "damping = { mass = \"5 1/s\" }\n"
            "boundary = [{ on = \"z-min\" }, { region.x = [\"0 mm\", \"1 mm\"], on = \"z-max\", region.y = "
            "[\"1 mm\", \"2 mm\"] }]\n"
            "time.integrator = \"verlet\"\n"
            "time.duration = \"20 us\"  # long\n"
            "[fracture]\n"
            "variation.of = \"both\"\n"
            "variation.modulus = 10\n"
            "\n[output]\n"
            "frames = 3\n");
}

TEST(Settings, CompleteWhatIsLeftOut) {
  const std::string found = completed(text, {{"mesh.base", "\"shared\""}, {"mesh.spacing", "\"9 mm\""}});
  EXPECT_EQ(found, with_settings(text, {{"mesh.base", "\"shared\""}}));
  EXPECT_EQ(completed(found, {{"mesh.base", "\"own\""}}), found);
  EXPECT_EQ(completed("[mesh", {{"mesh.base", "\"own\""}}), "[mesh");
}

TEST(Settings, RefuseWhatHasNoPlace) {
  EXPECT_THROW(with_settings(text, {{"specimen.notch[2].depth", "\"5 mm\""}}), InputError);
  EXPECT_THROW(with_settings(text, {{"boundary[1].rate[3]", "\"5 N/s\""}}), InputError);
  EXPECT_THROW(with_settings(text, {{"mesh.spacing.x", "1"}}), InputError);
  const std::string dotted = "mesh.spacing = \"3 mm\"\n";
  EXPECT_THROW(with_settings(dotted, {{"mesh", "1"}, {"mesh.growth", "2"}}), InputError);
}

TEST(Sweeps, AllCombinationsAreInputsOfTheirOwn) {
  const Parameters parameters = parse(R"([[sweep]]
key = "fracture.release"
values = ["element",
  "facet"]
)" + text + R"(
[[sweep]]
key = ["mesh.spacing", "ensemble.seed"]
values = [
  ["3 mm", 1],  # coarse
  ["2 mm", 2],
]
)",
                                      "plate.toml");
  ASSERT_EQ(parameters.sweeps.size(), 2u);
  const auto cases = sweep_cases(parameters, "plate.toml");
  ASSERT_EQ(cases.size(), 4u);
  EXPECT_EQ(to_string(cases[1].settings),
            "fracture.release = \"element\", mesh.spacing = \"2 mm\", ensemble.seed = 2");
  for (std::size_t i = 0; i < 4; ++i) {
    const Parameters& one = cases[i].parameters;
    EXPECT_EQ(one.fracture.release, i < 2 ? Release::element : Release::facet);
    EXPECT_EQ(one.mesh.spacing, i % 2 == 0 ? 3e-3 : 2e-3);
    EXPECT_EQ(one.seed, i % 2 + 1);
    EXPECT_TRUE(one.sweeps.empty());
    EXPECT_THAT(one.text, Not(HasSubstr("[[sweep]]")));
    EXPECT_THAT(one.text, HasSubstr("# likewise"));
    EXPECT_EQ(sample_identity(parse(one.text, "input.toml")), sample_identity(one)) << "stands for itself";
  }
}

TEST(Sweeps, TheParametersOfADistributionCanBeSwept) {
  const Parameters parameters = parse(text + R"(
[[random]]
key = "material.youngs_modulus"
distribution = "normal"
standard_deviation = "100 MPa"
[[sweep]]
key = "random[0].standard_deviation"
values = ["50 MPa", "200 MPa"]
)",
                                      "plate.toml");
  const auto cases = sweep_cases(parameters, "plate.toml");
  ASSERT_EQ(cases.size(), 2u);
  EXPECT_EQ(cases[1].parameters.random.at(0).standard_deviation, 200e6);
}

TEST(Sweeps, ACaseThatIsNoSoundInputIsNamed) {
  const Parameters parameters = parse(text + R"(
[[sweep]]
key = "specimen.notch[0].depth"
values = ["6 mm", "30 mm"]
)",
                                      "plate.toml");
  try {
    sweep_cases(parameters, "plate.toml");
    FAIL() << "a notch through the body was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.messages(),
                ElementsAre(::testing::AllOf(
                    ::testing::StartsWith("plate.toml:9: specimen.notch[0].depth: "),
                    ::testing::EndsWith(" (in case 1: specimen.notch[0].depth = \"30 mm\")"))));
  }
}

TEST(Settings, KnowWhatARandomInputAffects) {
  using enum Affects;
  RandomInput random{.key = "boundary[1].rate[2]"};
  EXPECT_TRUE(affects(random, {body, conditions}));
  EXPECT_FALSE(affects(random, {body, points, mesh}));
  random.moved.push_back({.key = "specimen.notch[0].depth"});
  EXPECT_TRUE(affects(random, {body}));
  EXPECT_FALSE(affects({.key = "fracture.strength"}, {body, points, place, mesh, conditions}));
}

TEST(Settings, NameTheContentsOfFiles) {
  Parameters parameters = parse(text, "plate.toml");
  parameters.mesh.points_digest = "1234";
  auto solid = std::make_shared<solid::Solid>();
  solid->digest = "5678";
  parameters.specimen.solid = solid;
  const auto settings = [&](Affects what) { return settings_of(parameters, {what}); };
  EXPECT_EQ(settings(Affects::body).front(), "specimen.solid with digest 5678");
  EXPECT_EQ(settings(Affects::points).back(), "mesh.points with digest 1234");
  EXPECT_THAT(settings(Affects::mesh), ::testing::Each(Not(HasSubstr("digest"))));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::input
