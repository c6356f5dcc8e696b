// SPDX-License-Identifier: GPL-3.0-or-later
// [[initial.stress]]: its values and the mistakes that users make.
#include "input/reader.h"
#include "unit/input_samples.h"

#include <gmock/gmock.h>

#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace crackle::test {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr const char* table = "[[initial.stress]]";
using Keys = std::vector<std::pair<std::string, std::string>>;

std::vector<InputTable> tables_with(const Keys& keys) {
  auto tables = minimal_tables();
  tables.push_back({table, keys});
  return tables;
}

std::vector<std::string> errors_with(const Keys& keys) {
  return errors_of(to_text(tables_with(keys)));
}

TEST(InitialStress, IsReadWithItsUnits) {
  auto tables = tables_with({{"along", R"("x")"}, {"surface", R"("-100 MPa")"}});
  tables.push_back({table,
                    {{"along", R"("y")"},
                     {"expansion", R"("8e-6 1/K")"},
                     {"temperature", R"([["0 mm", "-200 K"], ["1 mm", "0 K"]])"},
                     {"history", R"([["0 s", 0], ["2 s", 1]])"}}});
  tables.push_back({table,
                    {{"along", R"("x")"},
                     {"components", R"(["z"])"},
                     {"profile", R"([["0 mm", "-3 MPa"], ["2.5 mm", "3 MPa"], ["5 mm", "-3 MPa"]])"}}});
  const auto parameters = parse_tables(tables);
  ASSERT_EQ(parameters.initial_stresses.size(), 3U);
  const auto& [tempered, heat, profile] = std::tie(
      parameters.initial_stresses[0], parameters.initial_stresses[1], parameters.initial_stresses[2]);
  const std::pair<double, double> thickness{0, 0.005};
  EXPECT_DOUBLE_EQ(input::value_at(tempered, thickness, 0), -100e6);
  EXPECT_DOUBLE_EQ(input::value_at(tempered, thickness, 0.0025), 50e6);
  EXPECT_DOUBLE_EQ(input::value_at(tempered, thickness, 0.005), -100e6);
  EXPECT_TRUE(!tempered.has(0) && tempered.has(1) && tempered.has(2));
  EXPECT_DOUBLE_EQ(heat.expansion, 8e-6);
  EXPECT_DOUBLE_EQ(input::value_at(heat, {0, 0.0245}, 0.0005), -100);
  EXPECT_DOUBLE_EQ(input::value_at(heat, {0, 0.0245}, 0.02), 0);
  EXPECT_EQ(heat.history.back(), std::pair(2.0, 1.0));
  EXPECT_TRUE(profile.has(2) && !profile.has(1));
  EXPECT_DOUBLE_EQ(input::value_at(profile, thickness, 0.00125), 0);
  const std::string echo = input::echo(parameters);
  for (const char* line : {"initial.stress[0].surface ", "= -100 MPa", "initial.stress[1].expansion ",
                           "[[0 m, -200 K], [1 mm, 0 K]]", "initial.stress[2].components "})
    EXPECT_THAT(echo, HasSubstr(line));
  EXPECT_THAT(echo, Not(HasSubstr("initial.stress[0].profile")));
}

TEST(InitialStress, IsOfOneForm) {
  EXPECT_THAT(
      errors_with({{"along", R"("x")"}}),
      ElementsAre("test.toml:21: initial.stress[0]: has no stress; give exactly one of surface, profile "
                  "and temperature (with expansion)"));
  EXPECT_THAT(errors_with({{"along", R"("x")"},
                           {"surface", R"("-1 MPa")"},
                           {"temperature", R"([["0 mm", "1 K"]])"},
                           {"expansion", R"("1e-6 1/K")"}}),
              ElementsAre(HasSubstr("has surface and temperature; give exactly one")));
  EXPECT_THAT(
      errors_with({{"along", R"("x")"}, {"temperature", R"([["0 mm", "1 K"]])"}}),
      ElementsAre(HasSubstr("initial.stress[0].expansion: the key is missing, but temperature requires "
                            "it; give an expansion such as \"8e-6 1/K\"")));
  EXPECT_THAT(errors_with({{"along", R"("x")"}, {"surface", R"("-1 MPa")"}, {"expansion", R"("1e-6 1/K")"}}),
              ElementsAre(HasSubstr("initial.stress[0].expansion: belongs to temperature")));
  EXPECT_THAT(errors_with({{"surface", R"("-1 MPa")"}}), ElementsAre(HasSubstr("along")));
  EXPECT_THAT(errors_with({{"along", R"("x")"}, {"surface", R"("-1 MPa")"}, {"components", R"(["x", "y"])"}}),
              ElementsAre(HasSubstr("a normal stress along x that changes along x is not in equilibrium")));
}

TEST(InitialStress, ThatDoesNotBalanceIsRefusedWithItsResidue) {
  // Mean 2 MPa; the straight line through it from 0 to 4 MPa has the linear part.
  EXPECT_THAT(
      errors_with({{"along", R"("x")"}, {"profile", R"([["0 mm", "0 MPa"], ["5 mm", "4 MPa"]])"}}),
      ElementsAre("test.toml:23: initial.stress[0].profile: is not in equilibrium: from x = 0 mm to 5 mm "
                  "its mean is 2 MPa and its linear part +-2 MPa at the ends; subtract both"));
  // Constant outside the table.
  EXPECT_THAT(
      errors_with({{"along", R"("x")"}, {"profile", R"([["-1 mm", "3 MPa"], ["-0.5 mm", "1 MPa"]])"}}),
      ElementsAre(HasSubstr("its mean is 1 MPa and its linear part +-0 MPa")));
  const Keys balanced{{"along", R"("x")"},
                      {"profile", R"([["0 mm", "-3 MPa"], ["2.5 mm", "3 MPa"], ["5 mm", "-3 MPa"]])"}};
  EXPECT_THAT(errors_with(balanced), IsEmpty());
}

TEST(InitialStress, NeedsAscendingCoordinatesEquilibriumAndAKnownMaterial) {
  EXPECT_THAT(errors_with({{"along", R"("x")"}, {"profile", R"([["1 mm", "1 MPa"], ["1 mm", "0 MPa"]])"}}),
              ElementsAre(HasSubstr("initial.stress[0].profile[1][0]: \"1 mm\" is not above the coordinate "
                                    "before it; give ascending coordinates")));
  auto tables = tables_with({{"along", R"("x")"}, {"surface", R"("-1 MPa")"}});
  set_key(tables, "[time]", "start", R"("rest")");
  EXPECT_THAT(errors_of(to_text(tables)),
              ElementsAre(AllOf(StartsWith("test.toml:22: initial.stress[0]: needs equilibrium first"),
                                HasSubstr("\"quasi-static\", or \"equilibrium\""))));
  EXPECT_THAT(errors_with({{"along", R"("x")"},
                           {"expansion", R"("8e-6 1/K")"},
                           {"temperature", R"([["0 mm", "-200 K"]])"},
                           {"material", R"("glass")"}}),
              ElementsAre(HasSubstr("initial.stress[0].material: there is no material \"glass\"")));
  EXPECT_THAT(errors_with({{"along", R"("x")"},
                           {"expansion", R"("8e-6 1/K")"},
                           {"temperature", R"([["0 mm", "-200 degC"]])"}}),
              ElementsAre(HasSubstr("does not have the dimension of a change of temperature")));
}

TEST(InitialStress, MayBeRandomAndSwept) {
  auto tables = tables_with({{"along", R"("x")"}, {"surface", R"("-100 MPa")"}});
  tables.push_back({"[[random]]",
                    {{"key", R"("initial.stress[0].surface")"},
                     {"distribution", R"("normal")"},
                     {"standard_deviation", R"("5 MPa")"}}});
  const auto parameters = parse_tables(tables);
  const auto drawn = input::drawn(parameters, {-90e6}, "test.toml");
  EXPECT_DOUBLE_EQ(drawn.initial_stresses[0].surface, -90e6);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::test
