// SPDX-License-Identifier: GPL-3.0-or-later
// Invalid inputs at the level of the reader; the table of invalid inputs of the whole program is in
// tests/cli.
#include "input/reader.h"
#include "input/schema.h"
#include "unit/input_samples.h"

#include <gmock/gmock.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>

namespace crackle::test {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

TEST(InputErrors, NameFileLineKeyAndWhatIsAccepted) {
  EXPECT_THAT(
      errors_with("[mesh]", "spacing", R"("3 kg")"),
      ElementsAre(
          "test.toml:6: mesh.spacing: \"3 kg\" does not have the dimension of a length; give a length "
          "such as \"1.0 mm\""));
}

TEST(InputErrors, AllAreReportedInTheOrderOfTheLines) {
  auto tables = minimal_tables();
  set_key(tables, "[sections]", "y", R"(["30 mm"])");
  set_key(tables, "[material]", "density", "3");
  set_key(tables, "[ensemble]", "samples", "0");
  set_key(tables, "[fracture]", "typo", "0");
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(StartsWith("test.toml:2: ensemble.samples: "),
                                                      StartsWith("test.toml:10: material.density: "),
                                                      StartsWith("test.toml:14: fracture.typo: "),
                                                      StartsWith("test.toml:21: sections.y[0]: ")));
}

TEST(InputErrors, TextOfTheExceptionHasOneLineForEach) {
  const input::InputError error({"a.toml:1: b: c", "a.toml:2: d: e"});
  EXPECT_STREQ(error.what(), "a.toml:1: b: c\na.toml:2: d: e");
  EXPECT_THAT(error.messages(), ElementsAre("a.toml:1: b: c", "a.toml:2: d: e"));
}

TEST(InputErrors, ValuesThatDependOnAWrongOneAreNotJudged) {
  // Without a size, sections, notches and regions cannot be checked.
  auto tables = minimal_tables();
  set_key(tables, "[specimen]", "size", R"(["5 mm", "24.5 kg", "140 mm"])");
  set_key(tables, "[sections]", "y", R"(["30 mm"])");
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(HasSubstr("specimen.size[1]")));
  // Without an exponent the impulse has no dimension.
  EXPECT_THAT(errors_with("[fracture]", "exponent", R"("two")"), ElementsAre(HasSubstr("fracture.exponent")));
}

TEST(InputErrors, SectionsAreWhereACrackCanArrive) {
  const auto errors = [](const std::string& faces, const std::string& key, const std::string& value) {
    auto tables = minimal_tables();
    for (auto& table : tables)
      if (table.header == "[sections]") table.keys = {{key, value}};
    for (const char face : faces) {  // y, Y: y-min, y-max; z, Z: z-min, z-max
      const std::string name =
          std::string(1, static_cast<char>(std::tolower(face))) + (face < 'a' ? "-max" : "-min");
      tables.push_back({"[[specimen.notch]]",
                        {{"face", '"' + name + '"'},
                         {"at", name[0] == 'y' ? R"("65 mm")" : R"("12 mm")"},
                         {"depth", R"("6 mm")"},
                         {"height", R"("0.6 mm")"}}});
    }
    return errors_of(to_text(tables));
  };
  EXPECT_THAT(errors("y", "y", R"(["7 mm", "24 mm"])"), IsEmpty());
  EXPECT_THAT(errors("y", "y", R"(["3 mm", "7 mm"])"),
              ElementsAre("test.toml:20: sections.y[0]: no crack can reach 3 mm; give a length in a notch's "
                          "ligament: between 6 mm and 24.5 mm (specimen.notch[0])"));
  EXPECT_THAT(errors("y", "y", R"(["6 mm"])"), ElementsAre(HasSubstr("no crack can reach 6 mm")))
      << "the tip";
  EXPECT_THAT(errors("Y", "y", R"(["18.5 mm"])"), ElementsAre(HasSubstr("between 0 and 18.5 mm")));
  EXPECT_THAT(errors("yY", "y", R"(["3 mm", "21 mm"])"), IsEmpty()) << "the other notch's crack can";
  EXPECT_THAT(errors("", "y", R"(["3 mm"])"), IsEmpty()) << "no notch, no cracks to measure";
  EXPECT_THAT(errors("z", "z", R"(["7 mm", "139 mm"])"), IsEmpty());
  EXPECT_THAT(errors("z", "z", R"(["140 mm"])"), ElementsAre(HasSubstr("140 mm is not inside the length")));
  EXPECT_THAT(errors("z", "z", R"(["9 mm", "8 mm"])"), ElementsAre(HasSubstr("8 mm is not above 9 mm")));
  EXPECT_THAT(errors("Z", "z", R"(["135 mm"])"),
              ElementsAre(HasSubstr("between 0 and 134 mm (specimen.notch[0])")));
  EXPECT_THAT(
      errors("zZ", "y", R"(["7 mm", "9 mm"])"),
      ElementsAre(
          "test.toml:20: sections.y: no crack can reach them, since no notch is cut into a y-face; give "
          "sections.z instead, between 6 mm and 140 mm (specimen.notch[0]) or between 0 and 134 mm "
          "(specimen.notch[1])"
          ", or [[sections.line]], which cracks may cross anywhere"));
  EXPECT_THAT(errors("y", "z", R"(["7 mm"])"), ElementsAre(HasSubstr("no notch is cut into a z-face")));
  auto tables = minimal_tables();
  std::erase_if(tables, [](const auto& table) { return table.header == "[sections]"; });
  EXPECT_THAT(errors_of(to_text(tables)),
              ElementsAre(HasSubstr("sections: there are no cross-sections; give y")));
  tables.push_back({"[sections]", {}});
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(HasSubstr("test.toml:19: sections: there are no")));
}

TEST(InputErrors, StrengthOrToughnessIsGiven) {
  EXPECT_THAT(errors_with("[fracture]", "toughness", R"("3 J/m^2")"), IsEmpty());
  auto tables = minimal_tables();
  for (auto& table : tables)
    std::erase_if(table.keys, [](const auto& entry) { return entry.first == "strength"; });
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(HasSubstr("fracture.toughness: the key is missing")));
  set_key(tables, "[fracture]", "toughness", R"("3 N/m")");
  EXPECT_THAT(errors_of(to_text(tables)), IsEmpty());
  set_key(tables, "[fracture]", "toughness", R"("3 MPa")");
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(HasSubstr("give an energy per area")));
}

TEST(InputErrors, AStressIntensityIsReadInItsOwnKeyOnly) {
  auto tables = minimal_tables();
  for (auto& table : tables)
    std::erase_if(table.keys, [](const auto& entry) { return entry.first == "strength"; });
  set_key(tables, "[fracture]", "toughness", "\"0.98 MPa sqrt(m)\"");
  EXPECT_THAT(errors_of(to_text(tables)),
              ElementsAre(HasSubstr("is a stress intensity, K_Ic; give it as fracture.fracture_toughness")));
  set_key(tables, "[fracture]", "toughness", R"("30 J/m^2")");
  set_key(tables, "[fracture]", "fracture_toughness", R"("1 MPa m^0.5")");
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(HasSubstr("is given together with toughness")));
}

TEST(InputErrors, AToughnessIsForTheMeasuredPoissonsRatios) {
  auto tables = minimal_tables();
  for (auto& table : tables)
    std::erase_if(table.keys, [](const auto& entry) { return entry.first == "strength"; });
  set_key(tables, "[fracture]", "toughness", R"("3 N/m")");
  for (const char* const nu : {"0", "0.45"}) {
    set_key(tables, "[material]", "poisson_ratio", nu);
    EXPECT_THAT(errors_of(to_text(tables)), IsEmpty()) << nu;
  }
  for (const char* const nu : {"-0.1", "0.451", "0.49"}) {
    set_key(tables, "[material]", "poisson_ratio", nu);
    EXPECT_THAT(errors_of(to_text(tables)),
                ElementsAre(AllOf(HasSubstr("material.poisson_ratio: " + std::string(nu)),
                                  HasSubstr("from 0 to 0.45"), HasSubstr("fracture.strength"))));
  }
  // With softening both are given, and no strength is derived from the toughness.
  set_key(tables, "[fracture]", "strength", R"("1 MPa")");
  set_key(tables, "[fracture]", "toughness", R"("3 kN/m")");
  set_key(tables, "[fracture]", "release", R"("softening")");
  EXPECT_THAT(errors_of(to_text(tables)), IsEmpty());
}

TEST(InputErrors, ContactIsGivenInOneWay) {
  for (const char* const start : {"rest", "equilibrium", "quasi-static"}) {
    auto tables = minimal_tables();
    set_key(tables, "[fracture]", "contact", R"("frictionless")");
    set_key(tables, "[time]", "start", fmt::format("\"{}\"", start));
    EXPECT_THAT(errors_of(to_text(tables)), IsEmpty());
  }
  EXPECT_THAT(errors_with("[contact]", "stiffness", "0.1"),
              ElementsAre(HasSubstr("contact.friction: the key is missing; give a number such as 0.3")));
  EXPECT_THAT(errors_with("[contact]", "friction", "0.3"), IsEmpty());
}

TEST(InputErrors, MissingFilesAndFoldersAreNamed) {
  const auto message = [](const std::filesystem::path& file) -> std::string {
    try {
      input::read(file);
    } catch (const input::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("/nonexistent/plate.toml"),
              StartsWith("/nonexistent/plate.toml: there is no such file"));
  EXPECT_THAT(message(::testing::TempDir()), HasSubstr(": is a directory"));
}

TEST(InputErrors, BoundsAreOpenOrClosedAsDocumented) {
  EXPECT_THAT(errors_with("[mesh]", "perturbation", "0"), IsEmpty());
  EXPECT_THAT(errors_with("[mesh]", "perturbation", "0.4"), IsEmpty());
  EXPECT_THAT(errors_with("[mesh]", "perturbation", "0.4000001"), ElementsAre(HasSubstr("from 0 to 0.4")));
  EXPECT_THAT(errors_with("[mesh]", "min_quality", "0.5"), IsEmpty());
  EXPECT_THAT(errors_with("[mesh]", "growth", "1"), IsEmpty());
  EXPECT_THAT(errors_with("[material]", "poisson_ratio", "0.4999999"), IsEmpty());
  EXPECT_THAT(errors_with("[material]", "poisson_ratio", "-0.9999999"), IsEmpty());
  EXPECT_THAT(errors_with("[material]", "poisson_ratio", "0.5"), ElementsAre(HasSubstr("below 0.5")));
  EXPECT_THAT(errors_with("[ensemble]", "samples", "1000000"), IsEmpty());
  EXPECT_THAT(errors_with("[ensemble]", "samples", "1000001"), ElementsAre(HasSubstr("1000000")));
}

TEST(InputErrors, UnitsThatUdunitsReadsOtherwiseAreRefused) {
  // Each of these is a valid unit in UDUNITS, and convertible by its rules.
  for (const char* value : {R"("3 1/m")", R"("3 m-1")", R"("3 mm @ 5")", R"("3 mm 4")", R"("3 -4 mm")",
                            "\"3 lg(re 1 m)\"", R"("3 * mm")"}) {
    const auto errors = errors_with("[mesh]", "spacing", value);
    EXPECT_EQ(errors.size(), 1U) << value;
    for (const auto& error : errors) {
      EXPECT_THAT(error, ::testing::AnyOf(HasSubstr("has the unknown unit"),
                                          HasSubstr("does not have the dimension")))
          << value;
    }
  }
  for (const char* value : {R"("2mm")", R"("  2   mm ")", R"("+2 mm")", R"("2e0 mm")", R"("0.002 m")",
                            R"("2.0 mm^1")", R"("2000 µm")", R"("0.1 inch")", R"("2 m.mm/m")"}) {
    EXPECT_THAT(errors_with("[mesh]", "spacing", value), IsEmpty()) << value;
  }
}

TEST(InputErrors, UnitsMayBeTypeset) {
  auto tables = minimal_tables();
  std::erase_if(tables[4].keys, [](const auto& entry) { return entry.first == "strength"; });
  for (const char* value : {"1.0 MPa √m", "1.0 MPa·√m", "1 MPa √(m)", "1 MPa m½", "1 MPa·m^½",
                            "1\u00a0MPa sqrt(m)", "1 MPa\u2009m^0.5"}) {
    set_key(tables, "[fracture]", "fracture_toughness", "\"" + std::string(value) + "\"");
    ASSERT_THAT(errors_of(to_text(tables)), IsEmpty()) << value;
    EXPECT_DOUBLE_EQ(parse_tables(tables).fracture.fracture_toughness, 1e6) << value;
  }
  EXPECT_THAT(errors_with("[mesh]", "spacing", "\"\u22122 mm\""), ElementsAre(HasSubstr("is out of range")));
  EXPECT_THAT(errors_with("[mesh]", "spacing", "\"2 √mm\""), ElementsAre(HasSubstr("unknown unit")));
}

// A synonym that is a key, or of two keys, would advise something wrong.
TEST(InputErrors, SynonymsMeanOneKeyOfTheirTable) {
  std::size_t n = 0;
  for (const input::Table& table : input::schema()) {
    std::set<std::string> names;
    for (const input::Key& key : table.keys) names.insert(key.name);
    for (const input::Key& key : table.keys)
      for (const std::string& synonym : key.synonyms) {
        EXPECT_TRUE(names.insert(synonym).second) << table.path << "." << synonym;
        ++n;
      }
  }
  EXPECT_GT(n, 50U);
}

TEST(InputErrors, AnImpulseWithoutEffectIsSaid) {
  auto tables = minimal_tables();
  set_key(tables, "[fracture]", "accumulation", R"("step")");
  EXPECT_THAT(parse_tables(tables).notes, IsEmpty());
  set_key(tables, "[fracture]", "toughness", R"("150 J/m^2")");
  EXPECT_THAT(parse_tables(tables).notes, ElementsAre(HasSubstr("fracture.impulse: has no effect")));
  set_key(tables, "[fracture]", "release", R"("softening")");
  set_key(tables, "[mesh]", "spacing", R"("0.5 mm")");
  EXPECT_THAT(parse_tables(tables).notes, IsEmpty());
}

TEST(InputErrors, MessagesCannotSteerATerminal) {
  auto tables = minimal_tables();
  tables.push_back({"[[initial.stress]]",
                    {{"along", "\"x\""},
                     {"temperature", R"([["0 mm", "1 K"]])"},
                     {"expansion", R"("1e-6 1/K")"},
                     {"material", R"("a\u001b[31m\u009bb")"}}});
  EXPECT_THAT(errors_of(to_text(tables)), ElementsAre(HasSubstr("there is no material \"a?[31m?b\"")));
}

TEST(InputErrors, ConflictsAreJudgedByFaceRegionAndComponent) {
  const auto errors = [](const std::vector<std::pair<std::string, std::string>>& first,
                         const std::vector<std::pair<std::string, std::string>>& second) {
    auto tables = minimal_tables();
    tables.push_back({"[[boundary]]", first});
    tables.push_back({"[[boundary]]", second});
    return errors_of(to_text(tables));
  };
  const std::pair<std::string, std::string> on{"on", R"("z-max")"};
  const std::pair<std::string, std::string> lower{"region", R"({ y = ["0 mm", "10 mm"] })"};
  const std::pair<std::string, std::string> upper{"region", R"({ y = ["10 mm", "24.5 mm"] })"};
  const std::pair<std::string, std::string> middle{"region", R"({ y = ["9 mm", "24.5 mm"] })"};
  const std::pair<std::string, std::string> pull{"displacement", R"(["free", "free", "1 mm"])"};
  const std::pair<std::string, std::string> push{"velocity", R"(["free", "free", "-1 mm/s"])"};
  const std::pair<std::string, std::string> fix{"fix", R"(["x", "y"])"};
  const std::pair<std::string, std::string> fix_all{"fix", R"(["x", "y", "z"])"};
  EXPECT_THAT(errors({on, pull}, {on, push}), ElementsAre(HasSubstr("boundary[2]: prescribes motion in z")));
  EXPECT_THAT(errors({on, fix_all}, {on, push}), ElementsAre(HasSubstr("boundary[1] prescribes it too")));
  EXPECT_THAT(errors({on, pull, lower}, {on, push, middle}), ElementsAre(HasSubstr("boundary[2]")));
  EXPECT_THAT(errors({on, pull, lower}, {on, push, upper}), IsEmpty());
  EXPECT_THAT(errors({on, pull}, {on, fix}), IsEmpty());
  EXPECT_THAT(errors({on, fix}, {on, fix_all}), IsEmpty());
  EXPECT_THAT(errors({on, pull}, {{"on", R"("y-max")"}, push}), IsEmpty());
}

TEST(InputErrors, RestNeedsNoSupport) {
  auto tables = minimal_tables();
  set_key(tables, "[[boundary]]", "fix", R"(["z"])");
  EXPECT_THAT(errors_of(to_text(tables)),
              ElementsAre(HasSubstr("no condition supports the body in x and y")));
  set_key(tables, "[time]", "start", R"("rest")");
  EXPECT_THAT(errors_of(to_text(tables)), IsEmpty());
}

TEST(InputErrors, SyntaxErrorsAreOneLine) {
  const auto errors = errors_of("[mesh]\nspacing = 3 mm\n");
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_THAT(errors[0], AllOf(StartsWith("test.toml:2: syntax error: "), HasSubstr("must be in quotes")));
  EXPECT_EQ(errors[0].find('\n'), std::string::npos);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::test
