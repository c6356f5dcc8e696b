// SPDX-License-Identifier: GPL-3.0-or-later
// Valid but implausible values, and stress intensities in common units.
#include "crackle/input/plausibility.h"
#include "crackle/uncertainty/random_inputs.h"
#include "unit/input_samples.h"

#include <gmock/gmock.h>

namespace crackle::test {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> warnings_with(const std::string& header, const std::string& key,
                                       const std::string& value) {
  return input::plausibility_warnings(parse_with(header, key, value));
}

/// The minimal input with a toughness instead of its strength.
std::vector<InputTable> tough_tables(const std::string& key, const std::string& value) {
  auto tables = minimal_tables();
  for (auto& table : tables)
    std::erase_if(table.keys, [](const auto& entry) { return entry.first == "strength"; });
  set_key(tables, "[fracture]", key, value);
  return tables;
}

TEST(Plausibility, NothingIsSaidOfAnEpoxyPlate) {
  EXPECT_THAT(input::plausibility_warnings(parse_tables(minimal_tables())), IsEmpty());
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tough_tables("toughness", R"("60 J/m^2")"))),
              IsEmpty());
}

TEST(Plausibility, NamesTheSlipOfMillipascal) {
  EXPECT_THAT(warnings_with("[material]", "youngs_modulus", R"("32000 mPa")"),
              ElementsAre(AllOf(HasSubstr("softer than rubber"), HasSubstr("did you mean 32 GPa?"),
                                HasSubstr("mPa is millipascal"))));
  EXPECT_THAT(warnings_with("[fracture]", "strength", R"("35 mPa")"),
              ElementsAre(AllOf(HasSubstr("1.1e-11 of Young's modulus"), HasSubstr("did you mean 35 MPa?"))));
}

TEST(Plausibility, KnowsWhatSolidsAre) {
  EXPECT_THAT(warnings_with("[material]", "youngs_modulus", R"("3300 GPa")"),
              ElementsAre(HasSubstr("stiffer than diamond")));
  EXPECT_THAT(warnings_with("[material]", "density", R"("1.18 kg/m^3")"),
              ElementsAre(HasSubstr("did you mean 1.18 g/cm^3, which is 1180 kg/m^3?")));
  EXPECT_THAT(warnings_with("[material]", "density", R"("118000 kg/m^3")"),
              ElementsAre(HasSubstr("heavier than any solid")));
}

TEST(Plausibility, NoBondCarriesATenthOfTheModulus) {
  EXPECT_THAT(warnings_with("[fracture]", "strength", R"("350 MPa")"),
              ElementsAre(HasSubstr("more than a tenth of Young's modulus, 3.3 GPa")));
  EXPECT_THAT(warnings_with("[fracture]", "strength", R"("320 MPa")"), IsEmpty());
  EXPECT_THAT(
      input::plausibility_warnings(parse_tables(tough_tables("toughness", R"("30 J/mm^2")"))),
      ElementsAre(AllOf(HasSubstr("at a spacing of 2 mm"), HasSubstr("1 J/mm^2 is a million J/m^2"))));
}

TEST(Plausibility, GelsMayBeStrongForTheirStiffness) {
  auto tables = minimal_tables();
  set_key(tables, "[material]", "youngs_modulus", R"("150 kPa")");
  set_key(tables, "[fracture]", "strength", R"("20 kPa")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), ElementsAre(HasSubstr("like a gel")));
}

TEST(Plausibility, NamesTheKeyThatTheInputHas) {
  EXPECT_THAT(
      input::plausibility_warnings(parse_tables(tough_tables("fracture_toughness", R"("1 GPa m^0.5")"))),
      ElementsAre(AllOf(HasSubstr("fracture.fracture_toughness = 1000 MPa m^0.5"), HasSubstr("N/mm^1.5"))));
}

TEST(Plausibility, APhaseOfAThousandTransitsIsHardlyMeant) {
  EXPECT_THAT(warnings_with("[time]", "duration", R"("0.04 Ms")"),
              ElementsAre(AllOf(HasSubstr("time.duration = 40000 s is 4.8e+08 times"),
                                HasSubstr("Ms is megasecond"))));
  EXPECT_THAT(warnings_with("[time]", "duration", R"("10 ms")"), IsEmpty());
}

TEST(FractureToughness, IsReadInTheUnitsThatPeopleWrite) {
  for (const char* const value :
       {"1.5 MPa m^0.5", "1.5 MPa*m^(1/2)", "1.5 MPa.m^1/2", "1.5 MPa sqrt(m)", "1.5e6 Pa m**0.5",
        "1.5 MN/m^1.5", "1.5 MN m^-3/2", "47.4341649025257 N/mm^1.5", "1500 kPa sqrt(m)"}) {
    const auto parameters = parse_tables(tough_tables("fracture_toughness", '"' + std::string(value) + '"'));
    EXPECT_NEAR(parameters.fracture.fracture_toughness, 1.5e6, 1e-6) << value;
  }
}

TEST(FractureToughness, StandsForIrwinsEnergyInPlaneStrain) {
  const auto parameters = parse_tables(tough_tables("fracture_toughness", R"("1.5 MPa m^0.5")"));
  EXPECT_NEAR(parameters.fracture.toughness, 1.5e6 * 1.5e6 * (1 - 0.38 * 0.38) / 3300e6, 1e-9);
  EXPECT_THAT(input::echo(parameters), AllOf(HasSubstr("fracture.fracture_toughness"),
                                             HasSubstr("= 1.5 MPa m^0.5"), HasSubstr("583.3")));
}

TEST(FractureToughness, MayBeRandomAndFollowsARandomModulus) {
  auto tables = tough_tables("fracture_toughness", R"("1.5 MPa m^0.5")");
  tables.push_back({"[[random]]",
                    {{"key", R"("fracture.fracture_toughness")"},
                     {"distribution", R"("uniform")"},
                     {"lower", R"("1 MPa m^0.5")"},
                     {"upper", "\"2 MPa sqrt(m)\""}}});
  tables.push_back({"[[random]]",
                    {{"key", R"("material.youngs_modulus")"},
                     {"distribution", R"("uniform")"},
                     {"lower", R"("3 GPa")"},
                     {"upper", R"("4 GPa")"}}});
  const auto parameters = parse_tables(tables);
  const auto own = uncertainty::sample_parameters(parameters, 1);
  const double k = own.draw->values[0], modulus = own.draw->values[1];
  EXPECT_GT(k, 1e6);
  EXPECT_LT(k, 2e6);
  EXPECT_NEAR(own.fracture.toughness, k * k * (1 - 0.38 * 0.38) / modulus, 1e-9 * own.fracture.toughness);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::test
