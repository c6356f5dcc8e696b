// SPDX-License-Identifier: GPL-3.0-or-later
// Correct inputs: every key, its units and its default.
#include "input/reader.h"
#include "unit/input_samples.h"

#include "support/temporary_folder.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace crackle::test {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;
using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

/// Units are converted by one multiplication, which may round.
void expect_close(double value, double expected) {
  EXPECT_NEAR(value, expected, 1e-14 * std::abs(expected));
}

TEST(Input, EnsembleKeys) {
  const auto p = parse_tables([] {
    auto tables = minimal_tables();
    set_key(tables, "[ensemble]", "samples", "200");
    set_key(tables, "[ensemble]", "seed", "9223372036854775807");
    set_key(tables, "[ensemble]", "ranks_per_sample", "4");
    return tables;
  }());
  EXPECT_EQ(p.ensemble.samples, 200);
  EXPECT_EQ(p.seed, 9223372036854775807U);
  EXPECT_EQ(p.ensemble.ranks_per_sample, 4);
  EXPECT_FALSE(p.ensemble.stop.has_value());
}

TEST(Input, Defaults) {
  const auto p = parse_tables(minimal_tables());
  EXPECT_EQ(p.seed, 0U);
  EXPECT_EQ(p.ensemble.ranks_per_sample, 1);
  EXPECT_TRUE(p.specimen.notches.empty());
  EXPECT_EQ(p.mesh.notch_spacing, p.mesh.spacing);
  EXPECT_EQ(p.mesh.growth, 0.03);
  EXPECT_EQ(p.mesh.perturbation, 0.2);
  EXPECT_EQ(p.mesh.min_quality, 0.2);
  EXPECT_FALSE(p.mesh.points.has_value());
  EXPECT_EQ(p.fracture.exponent, 2);
  EXPECT_EQ(p.fracture.accumulation, input::Accumulation::cumulative);
  EXPECT_EQ(p.fracture.release, input::Release::element);
  EXPECT_EQ(p.time.start, input::Start::quasi_static);
  EXPECT_FALSE(p.time.step.has_value());
  EXPECT_FALSE(p.time.arrest.has_value());
  EXPECT_EQ(p.time.integrator, input::Integrator::bilateral4);
  EXPECT_EQ(p.time.engine, input::Engine::fixed_point);
  EXPECT_EQ(p.time.precision, input::Precision::mixed);
  EXPECT_EQ(p.output.frames, 11);
  EXPECT_EQ(p.text, to_text(minimal_tables()));
}

TEST(Input, SpecimenWithNotches) {
  auto tables = minimal_tables();
  tables.insert(
      tables.begin() + 2,
      {{"[[specimen.notch]]",
        {{"face", R"("y-min")"}, {"at", R"("65 mm")"}, {"depth", R"("6 mm")"}, {"height", R"("0.6 mm")"}}},
       {"[[specimen.notch]]",
        {{"face", R"("z-max")"}, {"at", R"("1 cm")"}, {"depth", R"("0.01 m")"}, {"height", R"("300 um")"}}}});
  const auto p = parse_tables(tables);
  expect_close(p.specimen.size[0], 5e-3);
  expect_close(p.specimen.size[1], 24.5e-3);
  expect_close(p.specimen.size[2], 140e-3);
  ASSERT_EQ(p.specimen.notches.size(), 2U);
  EXPECT_EQ(p.specimen.notches[0].face, Face::y_min);
  expect_close(p.specimen.notches[0].at, 65e-3);
  expect_close(p.specimen.notches[0].depth, 6e-3);
  expect_close(p.specimen.notches[0].height, 0.6e-3);
  EXPECT_EQ(p.specimen.notches[1].face, Face::z_max);
  expect_close(p.specimen.notches[1].at, 10e-3);
  expect_close(p.specimen.notches[1].depth, 10e-3);
  expect_close(p.specimen.notches[1].height, 0.3e-3);
}

TEST(Input, MeshKeys) {
  auto tables = minimal_tables();
  for (const auto& [key, value] :
       std::vector<std::pair<std::string, std::string>>{{"spacing", R"("1.5 mm")"},
                                                        {"notch_spacing", R"("0.5 mm")"},
                                                        {"growth", "0.1"},
                                                        {"perturbation", "0"},
                                                        {"min_quality", "0.5"}}) {
    set_key(tables, "[mesh]", key, value);
  }
  const auto p = parse_tables(tables);
  expect_close(p.mesh.spacing, 1.5e-3);
  expect_close(p.mesh.notch_spacing, 0.5e-3);
  EXPECT_EQ(p.mesh.growth, 0.1);
  EXPECT_EQ(p.mesh.perturbation, 0);
  EXPECT_EQ(p.mesh.min_quality, 0.5);
}

TEST(Input, SamplesHaveBasePointsOfTheirOwnUnlessItSaysOtherwise) {
  EXPECT_EQ(parse_tables(minimal_tables()).mesh.base, input::Base::own);
  EXPECT_EQ(test::parse_with("[mesh]", "base", R"("shared")").mesh.base, input::Base::shared);
}

TEST(Input, PointsAreRelativeToTheInputFile) {
  const test::TemporaryFolder temporary;
  const auto& folder = temporary.path();
  std::filesystem::create_directories(folder / "sub");
  std::ofstream(folder / "sub" / "cloud.txt") << "0 0 0\n";
  auto tables = minimal_tables();
  set_key(tables, "[mesh]", "points", R"("sub/cloud.txt")");
  std::ofstream(folder / "plate.toml") << to_text(tables);
  const auto p = input::read(folder / "plate.toml");
  ASSERT_TRUE(p.mesh.points.has_value());
  EXPECT_TRUE(std::filesystem::equivalent(*p.mesh.points, folder / "sub" / "cloud.txt"));
  EXPECT_EQ(p.mesh.base, input::Base::shared);
}

TEST(Input, MaterialAndFractureKeys) {
  auto tables = minimal_tables();
  set_key(tables, "[material]", "youngs_modulus", R"("3.3 GPa")");
  set_key(tables, "[material]", "density", R"("1.18 g/cm^3")");
  set_key(tables, "[material]", "poisson_ratio", "-0.25");
  set_key(tables, "[fracture]", "strength", R"("35 N/mm^2")");
  set_key(tables, "[fracture]", "accumulation", R"("step")");
  const auto p = parse_tables(tables);
  expect_close(p.materials[0].youngs_modulus, 3.3e9);
  expect_close(p.materials[0].density, 1180);
  EXPECT_EQ(p.materials[0].poisson_ratio, -0.25);
  expect_close(p.fracture.strength, 35e6);
  expect_close(p.fracture.impulse, 1e4);
  EXPECT_EQ(p.fracture.accumulation, input::Accumulation::step);
}

TEST(Input, ImpulseHasTheDimensionThatTheExponentGives) {
  const auto impulse = [](const std::string& exponent, const std::string& value) {
    auto tables = minimal_tables();
    set_key(tables, "[fracture]", "exponent", exponent);
    set_key(tables, "[fracture]", "impulse", value);
    return parse_tables(tables).fracture.impulse;
  };
  expect_close(impulse("1", R"("2 MPa us")"), 2.0);
  expect_close(impulse("2", R"("2 kPa2 s")"), 2e6);
  expect_close(impulse("3", R"("2 MPa^3 s")"), 2e18);
  expect_close(impulse("2.5", R"("3 MPa^2.5 ms")"), 3e15 * 1e-3);
  expect_close(impulse("0.5", R"("4 kPa^0.5 s")"), 4 * std::sqrt(1e3));
}

TEST(Input, TimeKeys) {
  auto tables = minimal_tables();
  set_key(tables, "[time]", "start", R"("rest")");
  set_key(tables, "[time]", "step", R"("5 ns")");
  set_key(tables, "[time]", "arrest", R"("20 µs")");
  set_key(tables, "[time]", "integrator", R"("verlet")");
  const auto p = parse_tables(tables);
  EXPECT_EQ(p.time.start, input::Start::rest);
  EXPECT_EQ(p.time.integrator, input::Integrator::verlet);
  expect_close(p.time.step.value(), 5e-9);
  expect_close(p.time.duration, 100e-6);
  expect_close(p.time.arrest.value(), 20e-6);
  EXPECT_FALSE(parse_with("[time]", "step", R"("auto")").time.step.has_value());
  EXPECT_FALSE(parse_with("[time]", "arrest", R"("auto")").time.arrest.has_value());
}

TEST(Input, SectionsAndOutput) {
  const auto p = parse_with("[sections]", "y", R"(["7 mm", "0.9 cm", "12.25e-3 m"])");
  ASSERT_EQ(p.sections.y.size(), 3U);
  expect_close(p.sections.y[0], 7e-3);
  expect_close(p.sections.y[1], 9e-3);
  expect_close(p.sections.y[2], 12.25e-3);
  EXPECT_TRUE(p.sections.z.empty());
  EXPECT_EQ(parse_with("[output]", "frames", "0").output.frames, 0);
}

/// With a notch in y-min, 6 mm deep, and one in z-max, 10 mm deep.
std::vector<InputTable> tables_with_notches() {
  auto tables = minimal_tables();
  tables.push_back(
      {"[[specimen.notch]]",
       {{"face", R"("y-min")"}, {"at", R"("65 mm")"}, {"depth", R"("6 mm")"}, {"height", R"("0.6 mm")"}}});
  tables.push_back(
      {"[[specimen.notch]]",
       {{"face", R"("z-max")"}, {"at", R"("12 mm")"}, {"depth", R"("10 mm")"}, {"height", R"("0.6 mm")"}}});
  return tables;
}

TEST(Input, SectionsAreNumberedByAxis) {
  auto tables = tables_with_notches();
  set_key(tables, "[sections]", "z", R"(["20 mm", "129 mm"])");
  const input::Sections sections = parse_tables(tables).sections;
  const auto all = sections.all();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(sections.size(), 3U);
  EXPECT_EQ(all[0].axis, 1);
  EXPECT_EQ(all[2].axis, 2);
  EXPECT_EQ(input::name_of(all[0]), "y = 12.25 mm");
  EXPECT_EQ(input::name_of(all[2]), "z = 129 mm");
}

TEST(Input, OtherSectionsAreReadLikeThoseOfTheFile) {
  const input::Parameters p = parse_tables(tables_with_notches());
  const auto lengths = [&](const std::vector<std::string>& given) {
    std::vector<std::string> names;
    for (const auto& section : input::with_sections(p, given, "--sections").sections.all())
      names.push_back(input::name_of(section));
    return names;
  };
  using ::testing::ElementsAre;
  EXPECT_THAT(lengths({"y=7 mm,0.9 cm"}), ElementsAre("y = 7 mm", "y = 9 mm"));
  EXPECT_THAT(lengths({"z = 1 cm", "y=7 mm", "y= 12.25 mm "}),
              ElementsAre("y = 7 mm", "y = 12.25 mm", "z = 10 mm"));
  EXPECT_EQ(input::with_sections(p, {"y=7 mm"}, "").text, p.text);
  const auto errors = [&](const std::vector<std::string>& given) -> std::vector<std::string> {
    try {
      input::with_sections(p, given, "--sections");
    } catch (const input::InputError& error) {
      return error.messages();
    }
    return {};
  };
  EXPECT_THAT(errors({"y=7 mm, 3 kg"}),
              ElementsAre("--sections: sections.y[1]: \"3 kg\" does not have the dimension of a "
                          "length; give a length such as \"1.0 mm\""));
  EXPECT_THAT(errors({"y=7 mm", "z=135 mm"}),
              ElementsAre("--sections: sections.z[0]: no crack can reach 135 mm; give a length in a notch's "
                          "ligament: between 0 and 130 mm (specimen.notch[1])"));
  EXPECT_THAT(errors({"y=9 mm", "y=7 mm"}), ElementsAre(::testing::HasSubstr("7 mm is not above 9 mm")));
  EXPECT_THAT(errors({"y=7 mm,"}), ElementsAre(::testing::HasSubstr("sections.y[1]: \"\" is not a number")));
  for (const char* wrong : {"7 mm", "x=7 mm", "=7 mm", ""})
    EXPECT_THAT(errors({wrong}), ElementsAre(::testing::HasSubstr("is not known; give y="))) << wrong;
}

TEST(Input, SectionsAlongLines) {
  using ::testing::ElementsAre;
  using ::testing::HasSubstr;
  const auto given = [](const char* from, const char* to) {
    auto tables = minimal_tables();
    tables.push_back({"[[sections.line]]", {{"from", from}, {"to", to}}});
    return parse_tables(tables);
  };
  const auto errors = [&](const char* from, const char* to) -> std::vector<std::string> {
    try {
      given(from, to);
    } catch (const input::InputError& error) {
      return error.messages();
    }
    return {};
  };
  const auto p = given(R"(["1 mm", "20 mm"])", R"(["0.3 cm", "-4 mm"])");
  const auto all = p.sections.all();
  ASSERT_EQ(all.size(), p.sections.size());
  EXPECT_EQ(all.back().axis, 0);
  expect_close(all.back().line.from[1], 20e-3);
  expect_close(all.back().line.to[1], -4e-3);
  EXPECT_EQ(input::name_of(all.back()), "line from (1 mm, 20 mm) to (3 mm, -4 mm)");
  EXPECT_STREQ(input::coordinate_of(all.back()), "distance");
  EXPECT_NE(input::sample_identity(p), input::sample_identity(parse_tables(minimal_tables())));

  EXPECT_THAT(errors(R"(["1 mm", "20 mm"])", R"(["0.1 cm", "20 mm"])"),
              ElementsAre(HasSubstr(
                  "sections.line[0].to: [1 mm, 20 mm] is also the start of the line; give another")));
  EXPECT_THAT(
      errors(R"(["-1 mm", "20 mm"])", R"(["-3 mm", "30 mm"])"),
      ElementsAre(HasSubstr("sections.line[0]: the line from [-1 mm, 20 mm] to [-3 mm, 30 mm] does not pass "
                            "through the body; give ends with y between 0 and 24.5 mm")));
  EXPECT_THAT(errors(R"(["0 mm", "20 mm"])", R"(["0 mm", "30 mm"])"), ElementsAre(HasSubstr("does not pass")))
      << "in its face";
  EXPECT_THAT(errors(R"(["-5 mm", "4 mm"])", R"(["4 mm", "-5 mm"])"), ElementsAre(HasSubstr("does not pass")))
      << "past its corner";
  EXPECT_TRUE(errors(R"(["-5 mm", "6 mm"])", R"(["6 mm", "-5 mm"])").empty()) << "across its corner";
  EXPECT_THAT(
      errors(R"(["1 mm"])", R"(["3 mm", "30 mm"])"),
      ElementsAre(HasSubstr("sections.line[0].from: the array has 1 element; give two lengths, y and z")));
  EXPECT_THAT(errors(R"(["1 mm", "2 mm"])", R"(["3 mm", "30 kg"])"),
              ElementsAre(HasSubstr("sections.line[0].to[1]: ")));

  const auto other = [&](const std::vector<std::string>& options) {
    return input::with_sections(p, options, "--sections").sections;
  };
  const auto found = other({"line=1 mm, 2 mm; 3 mm, 4 mm", "y=7 mm", "line = 1 cm,2 mm;3 mm,4 mm"});
  ASSERT_EQ(found.lines.size(), 2U);
  EXPECT_EQ(found.y.size(), 1U);
  EXPECT_EQ(input::name_of(found.all()[1]), "line from (1 mm, 2 mm) to (3 mm, 4 mm)");
  expect_close(found.lines[1].from[0], 0.01);
  EXPECT_THROW(other({"line=1 mm, 2 mm; 3 mm"}), input::InputError);
  EXPECT_THROW(other({"line=1 mm, 2 mm"}), input::InputError);
  EXPECT_THROW(other({"line=1 mm, 2 mm; 1 mm, 2 mm"}), input::InputError);
}

/// The minimal input with a second boundary.
input::Boundary second_boundary(const std::vector<std::pair<std::string, std::string>>& keys,
                                const std::string& start = R"("quasi-static")") {
  auto tables = minimal_tables();
  tables.push_back({"[[boundary]]", keys});
  set_key(tables, "[time]", "start", start);
  return parse_tables(tables).boundaries.at(1);
}

TEST(Input, FixedBoundary) {
  const auto b = second_boundary({{"on", R"("x-max")"}, {"fix", R"(["z", "x"])"}});
  EXPECT_EQ(b.on, "x-max");
  EXPECT_EQ(b.kind, BoundaryKind::fix);
  EXPECT_THAT(b.components, ElementsAre(true, false, true));
  EXPECT_EQ(b.region[1].first, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(b.region[1].second, std::numeric_limits<double>::infinity());
}

TEST(Input, ForceWithRateAndRegion) {
  const auto b = second_boundary({{"on", R"("z-max")"},
                                  {"region", R"({ y = ["10 mm", "20 mm"], x = ["0 mm", "2 mm"] })"},
                                  {"force", R"(["0 N", "-1 kN", "135 N"])"},
                                  {"rate", R"(["0 N/s", "0 N/s", "5 mN/ms"])"}});
  EXPECT_EQ(b.kind, BoundaryKind::force);
  EXPECT_THAT(b.value, ElementsAre(0, -1000, 135));
  EXPECT_THAT(b.rate, ElementsAre(0, 0, DoubleEq(5)));
  expect_close(b.region[1].first, 10e-3);
  expect_close(b.region[1].second, 20e-3);
  EXPECT_EQ(b.region[0].first, 0);
  expect_close(b.region[0].second, 2e-3);
}

TEST(Input, TractionWithHistory) {
  const auto b = second_boundary({{"on", R"("y-max")"},
                                  {"traction", R"(["0 Pa", "0 Pa", "2 MPa"])"},
                                  {"history", R"([["0 s", 0], ["1 min", 1.5], ["100 s", -1]])"}});
  EXPECT_EQ(b.kind, BoundaryKind::traction);
  EXPECT_THAT(b.value, ElementsAre(0, 0, 2e6));
  EXPECT_THAT(b.history, ElementsAre(Pair(0, 0), Pair(60, 1.5), Pair(100, -1)));
}

TEST(Input, MotionsMayLeaveComponentsFree) {
  const auto moved = second_boundary({{"on", R"("z-max")"},
                                      {"displacement", R"(["free", "0 mm", "0.5 mm"])"},
                                      {"rate", R"(["free", "0 m/s", "1 um/s"])"}});
  EXPECT_EQ(moved.kind, BoundaryKind::displacement);
  EXPECT_THAT(moved.components, ElementsAre(false, true, true));
  EXPECT_THAT(moved.value, ElementsAre(0, 0, DoubleEq(0.5e-3)));
  EXPECT_THAT(moved.rate, ElementsAre(0, 0, DoubleEq(1e-6)));
  const auto pulled = second_boundary({{"on", R"("z-max")"},
                                       {"velocity", R"(["free", "free", "3.6 km/h"])"},
                                       {"rate", R"(["free", "free", "2 m/s^2"])"}},
                                      R"("rest")");
  EXPECT_EQ(pulled.kind, BoundaryKind::velocity);
  EXPECT_THAT(pulled.components, ElementsAre(false, false, true));
  EXPECT_NEAR(pulled.value[2], 1, 1e-14);
  EXPECT_THAT(pulled.rate, ElementsAre(0, 0, 2));
}

TEST(Input, JobsOfTheProjectAreCorrect) {
  const std::filesystem::path jobs = std::filesystem::path(CRACKLE_SOURCE_DIR) / "jobs";
  int n_jobs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(jobs)) {
    if (entry.path().extension() != ".toml") continue;
    ++n_jobs;
    EXPECT_NO_THROW(input::read(entry.path())) << entry.path();
  }
  std::printf("%d jobs\n", n_jobs);
  EXPECT_GE(n_jobs, 2);
}

TEST(Input, OtherLineEndsAndByteOrderMarkAreText) {
  std::string text = to_text(minimal_tables());
  std::string windows = "\xef\xbb\xbf";
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(input::parse(windows, "test.toml").ensemble.samples, 3);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::test
