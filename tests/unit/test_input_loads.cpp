// SPDX-License-Identifier: GPL-3.0-or-later
// [[load]], and the factor of a [[boundary]].
#include "input/reader.h"

#include "input_samples.h"

#include <gmock/gmock.h>

#include <numbers>

namespace crackle {
namespace CRACKLE_TEST_FILE {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The minimal input with this instead of its boundary, and other lines of [time].
std::string text_with(const std::string& loads, const std::string& time = "start = \"rest\"\n") {
  std::string text = test::to_text(test::minimal_tables());
  text.insert(text.find("duration"), time);
  return text + loads;
}

std::vector<std::string> errors_with(const std::string& loads,
                                     const std::string& time = "start = \"rest\"\n") {
  try {
    input::parse(text_with(loads, time), "test.toml");
  } catch (const input::InputError& error) {
    return error.messages();
  }
  return {};
}

constexpr const char* all_loads = R"([[load]]
acceleration = ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]
rate = ["0 m/s^3", "1 mm/s^3", "0 m/s^3"]
[[load]]
body_force = ["0 N/m^3", "0 N/m^3", "2 kN/m^3"]
history = [["0 s", 0], ["2 us", 1]]
[[load]]
angular_velocity = "3000 rpm"
axis = [0, 0, 2]
point = ["1 mm", "2 mm", "3 mm"]
[[load]]
velocity = ["0 m/s", "1 m/s", "0 m/s"]
[[load]]
velocity_gradient = [["0 1/s", "0 1/s", "0 1/s"], ["0 1/s", "5 1/ms", "0 1/s"], ["1 1/s", "0 1/s", "5000 1/s"]]
center = ["0 mm", "12 mm", "70 mm"]
)";

TEST(InputLoads, AreReadInSIUnitsAndShownAgain) {
  const auto p = input::parse(text_with(all_loads), "test.toml");
  ASSERT_EQ(p.loads.size(), 5u);
  EXPECT_EQ(p.loads[0].at({1, 1, 1}), (Vector{0, 0, -9.81}));
  EXPECT_EQ(p.loads[0].rate, (Vector{0, 1e-3, 0}));
  EXPECT_EQ(p.loads[1].value, (Vector{0, 0, 2000}));
  EXPECT_EQ(p.loads[1].history.back(), (std::pair{2e-6, 1.0}));
  const double speed = 100 * std::numbers::pi;
  EXPECT_NEAR(p.loads[2].angular_velocity, speed, 1e-9);
  // Outwards from the axis, not along it.
  const Vector force = p.loads[2].at({0.001 + 0.5, 0.002, 7});
  EXPECT_NEAR(force[0] / (speed * speed * 0.5), 1, 1e-12);
  EXPECT_NEAR(force[1], 0, 1e-9);
  EXPECT_NEAR(force[2], 0, 1e-9);
  const Vector velocity = p.loads[4].at({0.001, 0.012, 0.08});
  EXPECT_NEAR(velocity[1], 0, 1e-12);
  EXPECT_NEAR(velocity[2], 0.001 + 50, 1e-9);
  EXPECT_EQ(p.body_forces().size(), 3u);
  EXPECT_EQ(p.initial_velocities().size(), 2u);
  const std::vector<std::string> shown = input::sample_settings(p);
  EXPECT_THAT(shown, ::testing::Contains("load[2].angular_velocity = 314.1592653589793 rad/s"));
  EXPECT_THAT(shown, ::testing::Contains("load[1].history = [[0 s, 0], [2 us, 1]]"));
  EXPECT_EQ(std::ranges::count_if(shown, [](const auto& line) { return line.starts_with("load["); }), 10);
}

TEST(InputLoads, HaveUnitsOfAngle) {
  const std::string rest = "axis = [1, 0, 0]\npoint = [\"0 m\", \"0 m\", \"0 m\"]\n";
  for (const auto& [text, value] : {std::pair{"2 rad/s", 2.0},
                                    {"1 rpm", std::numbers::pi / 30},
                                    {"180 degree/s", std::numbers::pi},
                                    {"2 rps", 4 * std::numbers::pi}})
    EXPECT_NEAR(input::parse(text_with(fmt::format("[[load]]\nangular_velocity = \"{}\"\n{}", text, rest)),
                             "test.toml")
                    .loads[0]
                    .angular_velocity,
                value, 1e-9)
        << text;
  for (const char* const text : {"50 Hz", "50 1/s"})
    EXPECT_THAT(errors_with(fmt::format("[[load]]\nangular_velocity = \"{}\"\n{}", text, rest)),
                ElementsAre(HasSubstr("has no unit of angle; give an angle per time, such as \"3000 rpm\"")));
  EXPECT_THAT(errors_with("[[load]]\nangular_velocity = \"3 m/s\"\n" + rest),
              ElementsAre(HasSubstr("does not have the dimension of an angular velocity")));
}

TEST(InputLoads, ExplainMistakes) {
  struct Mistake {
    const char* load;
    const char* message;
  };
  for (const auto& [load, message] : std::vector<Mistake>{
           {"", "load[0]: prescribes nothing; give one of acceleration, body_force, angular_velocity"},
           {"velocity = [\"0 m/s\", \"0 m/s\", \"1 m/s\"]\nacceleration = [\"0 m/s^2\", \"0 m/s^2\", \"1 "
            "m/s^2\"]",
            "prescribes acceleration and velocity; give exactly one of"},
           {"acceleration = [\"0 m/s^2\", \"0 m/s^2\"]", "three components"},
           {"acceleration = [\"0 m/s^2\", \"0 m/s^2\", \"1 m/s\"]", "dimension of an acceleration"},
           {"acceleration = [\"0 m/s^2\", \"0 m/s^2\", \"1 m/s^2\"]\naxis = [0, 0, 1]",
            "load[0].axis: belongs to angular_velocity, not to acceleration; leave it out"},
           {"angular_velocity = \"1 rpm\"\naxis = [1, 0, 0]",
            "load[0].point: the key is missing, but angular_velocity requires it; give point = "},
           {"angular_velocity = \"1 rpm\"\npoint = [\"0 m\", \"0 m\", \"0 m\"]\naxis = [0, 0, 0]",
            "has no direction"},
           {"angular_velocity = \"1 rpm\"\npoint = [\"0 m\", \"0 m\", \"0 m\"]\naxis = [0, 0, 1]\nrate = "
            "[\"0 m/s^3\", "
            "\"0 m/s^3\", \"1 m/s^3\"]",
            "give a history, whose factors multiply the load"},
           {"angular_velocity = \"1 rpm\"\npoint = [\"0 m\", \"0 m\", \"0 m\"]\naxis = [0, 0, 1]\nhistory = "
            "[[\"0 s\", "
            "0], [\"1 s\", -1]]",
            "a centrifugal force never points inwards"},
           {"velocity = [\"0 m/s\", \"0 m/s\", \"1 m/s\"]\nhistory = [[\"0 s\", 1]]", "leave it out"},
           {"velocity_gradient = [[\"0 1/s\", \"0 1/s\", \"0 1/s\"]]\ncenter = [\"0 m\", \"0 m\", \"0 m\"]",
            "three rows of three"},
           {"body_force = [\"0 N/m^3\", \"0 N/m^3\", \"1 N/m^3\"]\nrate = [\"0 N/m^3/s\", \"0 N/m^3/s\", "
            "\"1 N/m^3/s\"]\nhistory = [[\"0 s\", 1]]",
            "is given together with rate"}})
    EXPECT_THAT(errors_with(std::string("[[load]]\n") + load + "\n"), ElementsAre(HasSubstr(message)))
        << load;
  EXPECT_THAT(
      errors_with("[[load]]\nvelocity = [\"0 m/s\", \"0 m/s\", \"1 m/s\"]\n", ""),
      ElementsAre(HasSubstr("load[0].velocity: a velocity at the start requires time.start = \"rest\"")));
}

TEST(InputLoads, MayBeAllThatActs) {
  auto tables = test::minimal_tables();
  std::erase_if(tables, [](const auto& table) { return table.header == "[[boundary]]"; });
  test::set_key(tables, "[time]", "start", "\"rest\"");
  const std::string free = test::to_text(tables);
  EXPECT_EQ(input::parse(free + "[[load]]\nvelocity = [\"0 m/s\", \"0 m/s\", \"1 m/s\"]\n", "test.toml")
                .loads.size(),
            1u);
  EXPECT_THROW(input::parse(free, "test.toml"), input::InputError);
}

TEST(InputLoads, CanBeRandom) {
  const auto p = input::parse(text_with(R"([[load]]
angular_velocity = "3000 rpm"
axis = [0, 0, 2]
point = ["1 mm", "2 mm", "3 mm"]
[[random]]
key = "load[0].angular_velocity"
distribution = "normal"
standard_deviation = "100 rpm"
)"),
                              "test.toml");
  const auto own = input::drawn(p, {200}, "sample 0");
  EXPECT_NEAR(own.loads[0].angular_velocity, 200, 1e-9);
}

constexpr const char* shaped = R"([[boundary]]
on = "z-max"
traction = ["0 MPa", "0 MPa", "1 MPa"]
)";

TEST(InputFactor, IsATableOverACoordinate) {
  const auto p =
      input::parse(text_with(std::string(shaped) +
                             "factor = { along = \"y\", table = [[\"0 mm\", 0.0], [\"10 mm\", 1.0]] }\n"),
                   "test.toml");
  const auto& factor = p.boundaries.at(1).factor;
  ASSERT_TRUE(factor);
  EXPECT_EQ(factor->at(Vector{1, -1, 1}), 0);
  EXPECT_NEAR(factor->at(Vector{1, 0.0025, 1}), 0.25, 1e-15);
  EXPECT_EQ(factor->at(Vector{0, 1, 0}), 1);
  EXPECT_FALSE(p.boundaries[0].factor);
}

TEST(InputFactor, ExplainsMistakes) {
  const auto with = [](const std::string& factor) {
    return errors_with(std::string(shaped) + factor + "\n");
  };
  EXPECT_THAT(with("factor = { along = \"y\" }"),
              ElementsAre(HasSubstr("boundary[1].factor.table: the key is missing")));
  EXPECT_THAT(with("factor.table = [[\"0 mm\", 1]]"),
              ElementsAre(HasSubstr("boundary[1].factor.along: the key is missing")));
  EXPECT_THAT(with("factor = { along = \"t\", table = [[\"0 mm\", 1]] }"),
              ElementsAre(HasSubstr("\"x\", \"y\" or \"z\"")));
  EXPECT_THAT(with("factor = { along = \"y\", table = [[\"1 mm\", 1], [\"0 mm\", 1]] }"),
              ElementsAre(HasSubstr("is not above the length before it; give ascending lengths")));
  EXPECT_THAT(with("factor = { along = \"y\", table = [[\"1 s\", 1]] }"),
              ElementsAre(HasSubstr("dimension of a length")));
  EXPECT_THAT(errors_with("[[boundary]]\non = \"z-max\"\nfix = [\"x\"]\nfactor = { along = \"y\", table = "
                          "[[\"1 mm\", 1]] }\n"),
              ElementsAre(HasSubstr("boundary[1].factor: fix has no value to multiply; leave it out")));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle
