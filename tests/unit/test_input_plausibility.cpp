// SPDX-License-Identifier: GPL-3.0-or-later
// Valid but implausible values, and stress intensities in common units.
#include "input/plausibility.h"
#include "uncertainty/random_inputs.h"
#include "unit/input_samples.h"

#include <gmock/gmock.h>

#include <algorithm>

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

/// A modulus in MPa instead of GPa: the strength that follows from the toughness is four times as large.
TEST(Plausibility, DerivedStrengthsAreJudgedAtAnyStiffness) {
  for (const char* const modulus : {R"("3.3 MPa")", R"("33 MPa")"}) {
    auto tables = tough_tables("fracture_toughness", R"("0.6 MPa m^0.5")");
    set_key(tables, "[material]", "youngs_modulus", modulus);
    EXPECT_THAT(
        input::plausibility_warnings(parse_tables(tables)),
        ElementsAre(AllOf(HasSubstr("fracture.fracture_toughness = 0.6 MPa m^0.5 needs stresses of"),
                          HasSubstr("beyond the small strains"), HasSubstr("did you mean a modulus"))))
        << modulus;
  }
  // Where the mesh is finest the strength is highest; beside a given strength it holds at cracks.
  auto tables = tough_tables("toughness", R"("35 kJ/m^2")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), IsEmpty());
  set_key(tables, "[mesh]", "notch_spacing", R"("0.5 mm")");
  set_key(tables, "[fracture]", "strength", R"("160 MPa")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)),
              ElementsAre(HasSubstr("at a spacing of 0.5 mm, more than a tenth")));
  set_key(tables, "[fracture]", "length", R"("3 mm")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), IsEmpty());
  set_key(tables, "[fracture]", "toughness", R"("3.5 MJ/m^2")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)),
              ElementsAre(HasSubstr("with an averaging length of 3 mm")));
}

TEST(Plausibility, InterfacesAreJudgedLikeMaterials) {
  auto tables = minimal_tables();
  for (auto& table : tables)
    if (table.header == "[material]") table = {"[[material]]", table.keys};
  set_key(tables, "[[material]]", "name", R"("plate")");
  tables.push_back({"[[material]]",
                    {{"name", R"("disc")"},
                     {"youngs_modulus", R"("70 GPa")"},
                     {"poisson_ratio", "0.2"},
                     {"density", R"("2500 kg/m^3")"}}});
  tables.push_back({"[[specimen.region]]", {{"material", R"("disc")"}, {"z", R"(["90 mm", "140 mm"])"}}});
  tables.push_back({"[[interface]]", {{"between", R"(["plate", "disc"])"}, {"strength", R"("20 MPa")"}}});
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), IsEmpty());
  set_key(tables, "[[interface]]", "strength", R"("20 GPa")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)),
              ElementsAre(HasSubstr(
                  "interface[0].strength = 20 GPa is more than a tenth of Young's modulus, 3.3 GPa")));
  std::erase_if(tables, [](const auto& table) { return table.header == "[fracture]"; });
  tables.push_back({"[fracture]", {{"toughness", R"("60 J/m^2")"}, {"impulse", R"("1e-8 MPa^2 s")"}}});
  std::ranges::find(tables, "[[interface]]", &InputTable::header)->keys[1] = {"toughness", R"("8 J/mm^2")"};
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)),
              ElementsAre(HasSubstr("interface[0].toughness = 8 MJ/m^2 needs stresses of")));
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

TEST(Plausibility, CracksNeedLongerThanAWaveAcrossTheBody) {
  EXPECT_THAT(
      warnings_with("[time]", "duration", R"("14 us")"),
      ElementsAre(HasSubstr("time.duration = 14 us is shorter than a wave takes across 24.5 mm of the "
                            "body, 14.65 us")));
  EXPECT_THAT(warnings_with("[time]", "duration", R"("15 us")"), IsEmpty());
  auto tables = minimal_tables();
  set_key(tables, "[time]", "duration", R"("4 us")");
  set_key(tables, "[time]", "start", R"("rest")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), IsEmpty()) << "across the thickness";
}

TEST(Plausibility, AnImpulseThatKeepsTetrahedraFromBreakingIsHardlyMeant) {
  EXPECT_THAT(warnings_with("[fracture]", "impulse", R"("2e-2 MPa^2 s")"),
              ElementsAre(AllOf(HasSubstr("fracture.impulse = 0.02 MPa^2 s keeps"),
                                HasSubstr("for 16.33 us at twice its strength of about 35 MPa"))));
  EXPECT_THAT(warnings_with("[fracture]", "impulse", R"("1e-2 MPa^2 s")"), IsEmpty());
  auto tables = minimal_tables();
  set_key(tables, "[fracture]", "impulse", R"("2e-2 MPa^2 s")");
  set_key(tables, "[fracture]", "accumulation", R"("step")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), IsEmpty());
}

TEST(Plausibility, NothingMovesInNoTimeFromRest) {
  const auto warnings = [](const char* start, const InputTable& table) {
    auto tables = minimal_tables();
    set_key(tables, "[time]", "start", start);
    tables.push_back(table);
    return input::plausibility_warnings(parse_tables(tables));
  };
  const InputTable moved{"[[boundary]]",
                         {{"on", R"("z-max")"}, {"displacement", R"(["free", "free", "0.1 mm"])"}}};
  EXPECT_THAT(warnings(R"("rest")", moved), ElementsAre(HasSubstr("displaced by 0.1 mm at time 0 already")));
  EXPECT_THAT(warnings(R"("equilibrium")", moved), IsEmpty());
  InputTable slowly = moved;
  slowly.keys.emplace_back("history", R"([["0 s", 0], ["50 us", 1]])");
  EXPECT_THAT(warnings(R"("rest")", slowly), IsEmpty());
}

/// Of a wave in a bar of epoxy, 1672 m/s.
TEST(Plausibility, SmallStrainsEndAtAHundredthOfAWavesSpeed) {
  const auto warnings = [](const InputTable& table) {
    auto tables = minimal_tables();
    set_key(tables, "[time]", "start", R"("rest")");
    tables.push_back(table);
    return input::plausibility_warnings(parse_tables(tables));
  };
  const InputTable start{"[[load]]", {{"velocity", R"(["0 m/s", "0 m/s", "1 km/s"])"}}};
  EXPECT_THAT(warnings(start),
              ElementsAre(HasSubstr("a velocity of 1000 m/s is 60 % of a wave's, 1672 m/s")));
  EXPECT_THAT(warnings({"[[load]]", {{"velocity", R"(["0 m/s", "0 m/s", "16 m/s"])"}}}), IsEmpty());
  const auto on_end = [](const char* kind, const char* value, const char* change, const char* to) {
    return InputTable{"[[boundary]]", {{"on", R"("z-max")"}, {kind, value}, {change, to}}};
  };
  const char* const still = R"(["free", "free", "0 mm"])";
  EXPECT_THAT(warnings(on_end("displacement", still, "rate", R"(["free", "free", "18 m/s"])")),
              ElementsAre(HasSubstr("a velocity of 18 m/s")));
  EXPECT_THAT(warnings(on_end("displacement", R"(["free", "free", "1 mm"])", "history",
                              R"([["0 s", 0], ["50 us", 1]])")),
              ElementsAre(HasSubstr("a velocity of 20 m/s")));
  EXPECT_THAT(warnings(on_end("velocity", R"(["free", "free", "9 m/s"])", "history",
                              R"([["0 s", 0], ["50 us", 2]])")),
              ElementsAre(HasSubstr("a velocity of 18 m/s")));
  auto tables = minimal_tables();
  std::erase_if(tables, [](const auto& table) { return table.header == "[[boundary]]"; });
  set_key(tables, "[time]", "start", R"("rest")");
  tables.push_back(start);
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), IsEmpty()) << "in free flight";
}

TEST(Plausibility, AReferenceVolumeOfManyBodiesIsHardlyMeant) {
  auto tables = minimal_tables();
  tables.push_back(
      {"[fracture.variation]",
       {{"distribution", R"("weibull")"}, {"modulus", "8"}, {"reference_volume", R"("1 m^3")"}}});
  EXPECT_THAT(
      input::plausibility_warnings(parse_tables(tables)),
      ElementsAre(HasSubstr("5.8e+04 times the body's 17.15 cm^3: the body is then 3.9 times as strong")));
  set_key(tables, "[fracture.variation]", "reference_volume", R"("1 cm^3")");
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)), IsEmpty());
}

/// Beside a hole, whose crack may go anywhere; without one they are refused.
TEST(Plausibility, SectionsInsideANotchAreWarnedOf) {
  auto tables = minimal_tables();
  tables.push_back(
      {"[[specimen.notch]]",
       {{"face", R"("y-min")"}, {"at", R"("70 mm")"}, {"depth", R"("6 mm")"}, {"height", R"("1 mm")"}}});
  set_key(tables, "[sections]", "y", R"(["2 mm", "12 mm"])");
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(HasSubstr("sections.y[0]: no crack can reach 2 mm")));
  tables.push_back({"[[specimen.hole]]", {{"center", R"(["12 mm", "90 mm"])"}, {"radius", R"("4 mm")"}}});
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables)),
              ElementsAre(HasSubstr("no notch's crack can reach sections.y[0] = 2 mm")));
}

TEST(Plausibility, AHistoryHasRowsWithinTheDuration) {
  EXPECT_THAT(warnings_with("[output]", "history", R"("1 ms")"),
              ElementsAre(HasSubstr("output.history = 1 ms is longer than time.duration = 100 us")));
}

/// The minimal input, whose end z-min is held in all directions, with a load.
std::vector<InputTable> loaded(const char* on, const char* kind, const char* value,
                               const std::vector<std::pair<std::string, std::string>>& more = {}) {
  auto tables = minimal_tables();
  InputTable load{"[[boundary]]", {{"on", on}, {kind, value}}};
  load.keys.insert(load.keys.end(), more.begin(), more.end());
  tables.push_back(load);
  return tables;
}

TEST(IdleLoads, AreRefusedWhereTheBodyIsHeldInTheirDirection) {
  const auto errors = [](const auto& tables) { return errors_of(to_text(tables)); };
  for (const char* const on : {R"("z-min")", R"("edge-0")"})
    EXPECT_THAT(
        errors(loaded(on, "force", R"(["0 N", "0 N", "500 N"])")),
        ElementsAre(
            AllOf(HasSubstr("boundary[1]: its force acts only where boundary[0] prescribes the motion in z"),
                  HasSubstr("the body does not feel it"))));
  EXPECT_THAT(errors(loaded(R"("z-min")", "pressure", R"("2 MPa")")),
              ElementsAre(HasSubstr("its pressure acts only")));
  EXPECT_THAT(errors(loaded(R"("z-min")", "traction", R"(["0 Pa", "0 Pa", "0 Pa"])",
                            {{"rate", R"(["0 Pa/s", "1 MPa/s", "0 Pa/s"])"},
                             {"region", R"({ y = ["2 mm", "4 mm"] })"}})),
              ElementsAre(HasSubstr("its traction acts only")));
  auto beside = loaded(R"("z-max")", "force", R"(["0 N", "0 N", "100 N"])");
  beside.push_back({"[[boundary]]",
                    {{"on", R"("z-max")"},
                     {"displacement", R"(["free", "free", "0 mm"])"},
                     {"rate", R"(["free", "free", "0.001 mm/s"])"}}});
  EXPECT_THAT(errors(beside),
              ElementsAre(HasSubstr("its force acts only where boundary[2] prescribes the motion in z")));
}

TEST(IdleLoads, ThatActInPartAreWarnedOf) {
  const auto warnings = [](const auto& tables) { return input::plausibility_warnings(parse_tables(tables)); };
  EXPECT_THAT(warnings(loaded(R"("z-max")", "force", R"(["0 N", "0 N", "500 N"])")), IsEmpty());
  EXPECT_THAT(warnings(loaded(R"("y-min")", "pressure", R"("2 MPa")")), IsEmpty())
      << "only an edge in common";
  auto tables = loaded(R"("y-min")", "traction", R"(["0 Pa", "1 MPa", "0 Pa"])",
                       {{"region", R"({ z = ["40 mm", "80 mm"] })"}});
  const auto support = [&](const char* region, const char* axes) {
    auto supported = tables;
    supported.push_back({"[[boundary]]", {{"on", R"("y-min")"}, {"region", region}, {"fix", axes}}});
    return supported;
  };
  EXPECT_THAT(warnings(support(R"({ z = ["30 mm", "50 mm"] })", R"(["y"])")),
              ElementsAre(HasSubstr(
                  "25 % of the traction of boundary[1] act where boundary[2] prescribes the motion in y")));
  EXPECT_THAT(warnings(support(R"({ z = ["30 mm", "50 mm"] })", R"(["z"])")), IsEmpty())
      << "free in its direction";
  EXPECT_THAT(warnings(support(R"({ z = ["60 mm", "60 mm"] })", R"(["y"])")), IsEmpty())
      << "a line has no share";
  EXPECT_THAT(warnings(support(R"({ z = ["20 mm", "40 mm"] })", R"(["y"])")), IsEmpty()) << "beside it";
}

TEST(IdleLoads, AreFoundOnTheWallsOfAPlate) {
  const auto tables_with = [](const char* region) {
    auto tables = loaded(R"("z-min")", "force", R"(["0 N", "0 N", "5 N"])", {{"region", region}});
    tables.push_back({"[[specimen.hole]]", {{"center", R"(["12 mm", "70 mm"])"}, {"radius", R"("4 mm")"}}});
    set_key(tables, "[[boundary]]", "region", R"({ y = ["0 mm", "10 mm"] })");
    return tables;
  };
  EXPECT_THAT(input::plausibility_warnings(parse_tables(tables_with(R"({ y = ["5 mm", "15 mm"] })"))),
              ElementsAre(HasSubstr("50 % of the force of boundary[1]")));
  EXPECT_THAT(errors_of(to_text(tables_with(R"({ y = ["5 mm", "9 mm"] })"))),
              ElementsAre(HasSubstr("acts only")));
  auto hole = loaded(R"("hole-0")", "pressure", R"("2 MPa")");
  hole.push_back({"[[specimen.hole]]", {{"center", R"(["12 mm", "70 mm"])"}, {"radius", R"("4 mm")"}}});
  EXPECT_THAT(input::plausibility_warnings(parse_tables(hole)), IsEmpty());
  hole.push_back({"[[boundary]]", {{"on", R"("hole-0")"}, {"fix", R"(["y"])"}}});
  EXPECT_THAT(input::plausibility_warnings(parse_tables(hole)),
              ElementsAre(HasSubstr("100 % of the pressure")));
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
