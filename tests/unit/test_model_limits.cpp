// SPDX-License-Identifier: GPL-3.0-or-later
// Warnings about what the mesh cannot represent, with the size of the error; no warnings for inputs that it
// represents.
#include "dynamics/model_limits.h"
#include "input/reader.h"

#include "support/job.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Plate {
  std::string size = R"(["2 mm", "20 mm", "40 mm"])";
  std::string spacing = "1 mm";
  std::string poisson_ratio = "0.2";
  std::string fracture = R"(toughness = "30 J/m^2")";
  std::string conditions;
  std::string time = {};

  input::Parameters parameters() const {
    return input::parse(fmt::format(R"([ensemble]
samples = 1
[specimen]
size = {}
[mesh]
spacing = "{}"
[material]
youngs_modulus = "32 GPa"
poisson_ratio = {}
density = "2450 kg/m^3"
[fracture]
{}
impulse = "1e-8 MPa^2 s"
{}
[time]
duration = "40 us"
{}
[sections]
y = ["5 mm"]
)",
                                    size, spacing, poisson_ratio, fracture, conditions, time),
                        "plate.toml");
  }
};

std::vector<std::string> warnings(const input::Parameters& parameters) {
  return model_warnings(parameters, *geometry::make_body(parameters.specimen));
}

constexpr const char* clamp = R"([[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
)";
constexpr const char* pull = R"([[boundary]]
on = "z-max"
force = ["0 N", "0 N", "0 N"]
rate = ["0 N/s", "0 N/s", "1 N/s"]
)";
constexpr const char* bend = R"([[boundary]]
on = "z-max"
force = ["0 N", "0 N", "0 N"]
rate = ["1 N/s", "0 N/s", "0 N/s"]
)";

TEST(ModelLimits, BendingOutOfThePlaneNeedsCellsThroughTheThickness) {
  Plate plate{.size = R"(["1 mm", "10 mm", "40 mm"])", .conditions = std::string(clamp) + bend};
  EXPECT_THAT(warnings(plate.parameters()),
              ElementsAre(AllOf(HasSubstr("boundary[1]"), HasSubstr("has 1 cell:"),
                                HasSubstr("about 3.9 times too stiff"), HasSubstr("at most 0.25 mm"))));
  plate.spacing = "0.5 mm";
  EXPECT_THAT(warnings(plate.parameters()), ElementsAre(HasSubstr("about 1.7 times too stiff")));
  plate.spacing = "0.25 mm";
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty());

  plate.spacing = "1 mm";
  plate.conditions = std::string(clamp) + pull;
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty());
  const std::string held = "[[boundary]]\non = \"x-min\"\nfix = [\"x\"]\n";
  plate.conditions = std::string(clamp) + bend + held;
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty()) << "held along a whole side it cannot bend";
  const std::string pressed = "[[boundary]]\non = \"x-max\"\npressure = \"1 MPa\"\n";
  plate.conditions = clamp + pressed;
  EXPECT_THAT(warnings(plate.parameters()), ElementsAre(HasSubstr("boundary[1] loads the plate across")));
  plate.conditions = clamp + pressed + "[[boundary]]\non = \"x-min\"\npressure = \"1 MPa\"\n";
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty()) << "pressed from both sides it does not bend";
}

TEST(ModelLimits, TheMeasuredFactorsStandAtTheirCells) {
  for (const auto& [cells, ratio] : {std::pair{1.0, 3.9}, {2.0, 1.7}, {3.0, 1.3}, {4.0, 1.16}})
    EXPECT_NEAR(bending_stiffness_ratio(cells), ratio, 0.005);
  EXPECT_NEAR(bending_stiffness_ratio(1.5), 1 + 2.85 / 2.25, 1e-12);
  EXPECT_LT(bending_stiffness_ratio(8), 1.05);
}

TEST(ModelLimits, NearlyIncompressibleTetrahedraLock) {
  Plate plate{.poisson_ratio = "0.45", .conditions = std::string(clamp) + pull};
  EXPECT_THAT(warnings(plate.parameters()),
              ElementsAre(AllOf(HasSubstr("Poisson's ratio 0.45"), HasSubstr("1.06 times too stiff"),
                                Not(HasSubstr("strength")))));
  plate.fracture = R"(strength = "30 MPa")";
  EXPECT_THAT(warnings(plate.parameters()), ElementsAre(HasSubstr("breaks at about 0.94 times its load")));
  plate.fracture += "\nnucleation = \"own-stress\"";
  EXPECT_THAT(warnings(plate.parameters()), ElementsAre(HasSubstr("breaks at about 0.7 times its load")));
  plate.poisson_ratio = "0.49";
  EXPECT_THAT(warnings(plate.parameters()),
              ElementsAre(AllOf(HasSubstr("1.14 times too stiff"), HasSubstr("0.3 times its load"))));
  plate.poisson_ratio = "0.4";
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty());
}

TEST(ModelLimits, ACrackInAPlaneOfSymmetryTakesMoreLoad) {
  const std::string supports = R"([[boundary]]
on = "y-min"
region = { z = ["38 mm", "40 mm"] }
fix = ["x", "y"]
[[boundary]]
on = "y-max"
region = { z = ["0 mm", "1 mm"] }
displacement = ["free", "0 mm", "free"]
rate = ["free", "-0.001 mm/s", "free"]
)";
  const auto end = [](const char* held, const char* region) {
    return fmt::format("[[boundary]]\non = \"z-min\"\nfix = [{}]\n{}", held, region);
  };
  const char* const ligament = "region = { y = [\"8 mm\", \"20 mm\"] }\n";
  Plate plate;
  plate.conditions = end("\"z\"", ligament) + supports;
  EXPECT_THAT(warnings(plate.parameters()),
              ElementsAre(AllOf(HasSubstr("boundary[0] constrains 60 % of an end along z only"),
                                HasSubstr("about 1.4 times the load"), HasSubstr("model both halves"))));
  plate.conditions = end("\"y\", \"z\"", ligament) + supports;
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty()) << "a clamp";
  plate.conditions = end("\"z\"", "") + supports;
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty()) << "a roller along the whole end has no crack";
  plate.conditions = end("\"z\"", "region = { y = [\"9 mm\", \"11 mm\"] }\n") + supports;
  EXPECT_THAT(warnings(plate.parameters()), IsEmpty()) << "a support";
}

TEST(ModelLimits, LoadsThatRiseWithinAFewTransitsNeedInertia) {
  Plate plate{.conditions = std::string(clamp) + pull};
  const auto quasi_static = plate.parameters();
  EXPECT_THAT(fast_loading_warning(quasi_static.time.start, 0.42e-6, 10.5e-6),
              AllOf(HasSubstr("after 420 ns"), HasSubstr("takes 10.5 us"), HasSubstr("start = \"rest\"")));
  EXPECT_EQ(fast_loading_warning(quasi_static.time.start, 60e-6, 10.5e-6), "");
  EXPECT_EQ(fast_loading_warning(quasi_static.time.start, std::numeric_limits<double>::quiet_NaN(), 10.5e-6),
            "");
  plate.time = "start = \"rest\"";
  EXPECT_EQ(fast_loading_warning(plate.parameters().time.start, 0.42e-6, 10.5e-6), "");
}

TEST(ModelLimits, NothingIsSaidOfTheJobs) {
  const auto jobs = std::filesystem::path(CRACKLE_SOURCE_DIR) / "jobs";
  int n_read = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(jobs)) {
    if (entry.path().extension() != ".toml" || entry.path().parent_path().filename() == "experiments")
      continue;
    const auto file = std::filesystem::relative(entry.path(), jobs).string();
    const input::Parameters parameters = test::job(file);
    // Bodies that must not break have a strength above that of atomic bonds.
    if (parameters.fracture.strength >= 1e11)
      EXPECT_THAT(warnings(parameters), ElementsAre(HasSubstr("which no solid sustains"))) << file;
    else
      EXPECT_THAT(warnings(parameters), IsEmpty()) << file;
    ++n_read;
  }
  EXPECT_GT(n_read, 15);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
