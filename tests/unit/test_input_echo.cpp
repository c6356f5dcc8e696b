// SPDX-License-Identifier: GPL-3.0-or-later
// The echo of the resolved input is itself a complete description of it, and the table of keys names them
// all.
#include "common/checksum.h"
#include "input/reader.h"
#include "input/schema.h"

#include "unit/input_samples.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace crackle::test {
namespace CRACKLE_TEST_FILE {

/// An input with all keys except those of [ensemble.stop] and the points file.
std::vector<InputTable> full_tables() {
  return {{"[ensemble]",
           {{"samples", "17"},
            {"seed", "2012"},
            {"ranks_per_sample", "2"},
            {"meshes", R"("groups")"},
            {"plan", R"("latin-hypercube")"},
            {"replicates", "3"}}},
          {"[specimen]", {{"size", R"(["5 mm", "24.5 mm", "140 mm"])"}}},
          {"[[specimen.notch]]",
           {{"face", R"("y-max")"},
            {"at", R"("75.3 mm")"},
            {"depth", R"("6.21 mm")"},
            {"height", R"("0.6 mm")"}}},
          {"[[specimen.notch]]",
           {{"face", R"("z-min")"}, {"at", R"("12 mm")"}, {"depth", R"("11 mm")"}, {"height", R"("50 um")"}}},
          {"[mesh]",
           {{"spacing", R"("1.25 mm")"},
            {"notch_spacing", R"("0.3 mm")"},
            {"growth", "0.07"},
            {"perturbation", "0.15"},
            {"min_quality", "0.21"},
            {"base", R"("own")"}}},
          {"[[mesh.region]]",
           {{"x", R"(["-1 mm", "2 mm"])"},
            {"y", R"(["0 mm", "24.5 mm"])"},
            {"z", R"(["60 mm", "80 mm"])"},
            {"spacing", R"("0.31 mm")"}}},
          {"[[mesh.region]]", {{"z", R"(["20 mm", "30 mm"])"}, {"spacing", R"("0.5 mm")"}}},
          {"[material]",
           {{"youngs_modulus", R"("210 GPa")"}, {"poisson_ratio", "0.3"}, {"density", R"("7850 kg/m^3")"}}},
          {"[fracture]",
           {{"strength", R"("350 MPa")"},
            {"exponent", "1.5"},
            {"impulse", R"("2.5e-7 MPa^1.5 s")"},
            {"accumulation", R"("step")"},
            {"release", R"("element")"},
            {"release_time", R"("0 s")"}}},
          {"[fracture.variation]",
           {{"of", R"("toughness")"},
            {"distribution", R"("weibull")"},
            {"modulus", "12.5"},
            {"reference_volume", R"("2 cm^3")"},
            {"correlation_length", R"("1.7 mm")"}}},
          {"[[boundary]]", {{"on", R"("z-min")"}, {"fix", R"(["x", "z"])"}}},
          {"[[boundary]]",
           {{"on", R"("z-max")"},
            {"region", R"({ x = ["1 mm", "4 mm"], y = ["-1 mm", "20 mm"], z = ["139 mm", "141 mm"] })"},
            {"name", R"("grip A")"},
            {"force", R"(["0 N", "1.5 N", "135 N"])"},
            {"rate", R"(["0 N/s", "1 mN/s", "5 N/s"])"}}},
          {"[[boundary]]",
           {{"on", R"("y-max")"},
            {"traction", R"(["0 Pa", "3 kPa", "-1 MPa"])"},
            {"history", R"([["0 s", 0], ["20 ms", 1.25], ["3 s", -2]])"}}},
          {"[[boundary]]", {{"on", R"("x-min")"}, {"velocity", R"(["free", "2 mm/s", "free"])"}}},
          {"[[boundary]]",
           {{"on", R"("x-max")"},
            {"displacement", R"(["0.1 mm", "free", "free"])"},
            {"rate", R"(["3 um/s", "free", "free"])"}}},
          {"[[boundary]]", {{"on", R"("y-min")"}, {"absorbing", "true"}}},
          {"[time]",
           {{"start", R"("quasi-static")"},
            {"step", R"("5 ns")"},
            {"duration", R"("123 us")"},
            {"integrator", R"("verlet")"},
            {"arrest", R"("20 us")"}}},
          {"[damping]", {{"mass", R"("2.5 1/ms")"}, {"bulk", "[0.06, 1.2]"}}},
          {"[sections]", {{"y", R"(["7 mm", "9 mm", "12.25 mm"])"}, {"z", R"(["11.5 mm", "30 mm"])"}}},
          {"[[sections.line]]", {{"from", R"(["10 mm", "60 mm"])"}, {"to", R"(["14.5 mm", "-1 mm"])"}}},
          {"[[sections.line]]", {{"from", R"(["2 mm", "3 mm"])"}, {"to", R"(["2 mm", "9 mm"])"}}},
          {"[output]",
           {{"frames", "3"},
            {"history", R"("0.25 us")"},
            {"governing", R"("grip A")"},
            {"branch_length", R"("1.5 mm")"}}},
          {"[[output.probe]]", {{"name", R"("gauge A")"}, {"at", R"(["2.5 mm", "12 mm", "40 mm"])"}}},
          {"[[random]]",
           {{"key", R"("material.density")"},
            {"distribution", R"("triangular")"},
            {"lower", R"("7000 kg/m^3")"},
            {"upper", R"("8000 kg/m^3")"},
            {"mode", R"("7900 kg/m^3")"}}},
          {"[[random]]",
           {{"key", R"("fracture.impulse")"},
            {"distribution", R"("truncated")"},
            {"mean", R"("2e-7 MPa^1.5 s")"},
            {"standard_deviation", R"("5e-8 MPa^1.5 s")"},
            {"lower", R"("1e-8 MPa^1.5 s")"}}},
          {"[[random]]",
           {{"key", R"("boundary[1].rate[2]")"},
            {"distribution", R"("weibull")"},
            {"scale", R"("5 N/s")"},
            {"shape", "12.5"}}}};
}

/// Plates with an outline, with every key that a box does not have.
std::vector<std::vector<InputTable>> plates() {
  const std::vector<InputTable> holes{
      {"[[specimen.hole]]", {{"center", R"(["30 mm", "40 mm"])"}, {"radius", R"("3 mm")"}}},
      {"[[specimen.hole]]",
       {{"center", R"(["20 mm", "25 mm"])"},
        {"semi_axes", R"(["4 mm", "2 mm"])"},
        {"angle", R"("30.5 degree")"}}},
      {"[[specimen.hole]]", {{"polygon", R"([["30 mm", "20 mm"], ["34 mm", "20 mm"], ["32 mm", "24 mm"]])"}}},
      {"[[specimen.notch]]",
       {{"from", R"(["12 mm", "30 mm"])"},
        {"to", R"(["20 mm", "35 mm"])"},
        {"height", R"("0.7 mm")"},
        {"end", R"("round")"}}},
      {"[[boundary]]", {{"on", R"("hole-0")"}, {"pressure", R"("-2 MPa")"}, {"rate", R"("3 kPa/s")"}}}};
  std::vector<std::vector<InputTable>> all(2, minimal_tables());
  for (auto& tables : all) {
    tables[1].keys = {{"thickness", R"("4 mm")"}};
    tables.insert(tables.end(), holes.begin(), holes.end());
  }
  set_key(all[0], "[specimen]", "outline",
          R"([["0 mm", "0 mm"], ["50 mm", "0 mm"], ["50 mm", "50 mm"], ["0 mm", "50 mm"]])");
  set_key(all[1], "[specimen]", "outline", R"("circle")");
  set_key(all[1], "[specimen]", "radius", R"("25 mm")");
  return all;
}

/// A value of the echo as written in an input file: everything but plain numbers and "true" in quotes.
std::string as_written(const std::string& shown) {
  std::string text;
  std::string item;
  const auto finish_item = [&] {
    const auto first = item.find_first_not_of(' ');
    if (first == std::string::npos) return;
    item.erase(0, first);
    double number = 0;
    const auto end = std::from_chars(item.data(), item.data() + item.size(), number).ptr;
    const bool is_bare = end == item.data() + item.size() || item == "true";
    text += is_bare ? item : '"' + item + '"';
    item.clear();
  };
  bool is_index = false;  // inside the brackets of "boundary[1]"
  for (const char c : shown) {
    is_index = is_index || (c == '[' && item.find_first_not_of(' ') != std::string::npos);
    if (is_index) {
      item += c;
      is_index = c != ']';
    } else if (c == '[' || c == ']' || c == ',') {
      finish_item();
      text += c;
    } else {
      item += c;
    }
  }
  finish_item();
  return text;
}

/// A body of two materials, with regions of every shape.
std::vector<InputTable> regions() {
  auto tables = minimal_tables();
  const auto material = std::ranges::find(tables, "[material]", &InputTable::header);
  material->header = "[[material]]";
  material->keys.emplace_back("name", R"("plate")");
  InputTable other = *material;
  other.keys.back().second = R"("layer")";
  for (const auto& key : std::vector<std::pair<std::string, std::string>>{
           {"strength", R"("50 MPa")"}, {"impulse", R"("1e-7 MPa^2 s")"}, {"release_speed", R"("500 m/s")"}})
    other.keys.push_back(key);
  tables.push_back(other);
  tables.push_back({"[material.variation]",
                    {{"of", R"("both")"},
                     {"distribution", R"("weibull")"},
                     {"modulus", "30"},
                     {"correlation_length", R"("1.5 mm")"},
                     {"with_strength", "0.4"}}});
  tables.push_back({"[material.map]",
                    {{"file", R"("ct-{sample}.h5")"},
                     {"dataset", R"("/factors")"},
                     {"of", R"("both")"},
                     {"axes", R"(["z", "y"])"},
                     {"origin", R"(["0.5 mm", "0.5 mm"])"},
                     {"spacing", R"(["1 mm", "-1 mm"])"},
                     {"scale", "0.25"},
                     {"checksum", R"("3 files")"}}});
  tables.push_back(
      {"[fracture.variation]",
       {{"distribution", R"("weibull")"}, {"modulus", "12"}, {"correlation_length", R"("1.5 mm")"}}});
  tables.push_back({"[[interface]]", {{"between", R"(["plate", "layer"])"}, {"strength", R"("20 MPa")"}}});
  const auto add = [&](std::vector<std::pair<std::string, std::string>> keys) {
    keys.emplace_back("material", R"("layer")");
    tables.push_back({"[[specimen.region]]", std::move(keys)});
  };
  add({{"x", R"(["1 mm", "2 mm"])"}, {"y", R"(["2 mm", "9 mm"])"}, {"z", R"(["20 mm", "30 mm"])"}});
  add({{"center", R"(["12 mm", "60 mm"])"}, {"radius", R"("5 mm")"}});
  add({{"center", R"(["12 mm", "80 mm"])"},
       {"semi_axes", R"(["8 mm", "5 mm"])"},
       {"angle", R"("20 degree")"}});
  add({{"polygon", R"([["4 mm", "100 mm"], ["20 mm", "100 mm"], ["12 mm", "120 mm"]])"},
       {"x", R"(["3 mm", "5 mm"])"}});
  return tables;
}

/// Loads on the whole body, factors along a face and a tool that spins, at rest and in equilibrium.
std::vector<std::vector<InputTable>> loads() {
  std::vector<std::vector<InputTable>> all(2, minimal_tables());
  std::vector<InputTable>&struck = all[0], &still = all[1];
  set_key(struck, "[time]", "start", R"("rest")");
  struck.push_back({"[[load]]", {{"velocity", R"(["0 m/s", "1 m/s", "-2 m/s"])"}}});
  struck.push_back(
      {"[[load]]",
       {{"velocity_gradient",
         R"([["0 1/s", "0 1/s", "0 1/s"], ["0 1/s", "5000 1/s", "0 1/s"], ["0 1/s", "0 1/s", "1 1/s"]])"},
        {"center", R"(["0 mm", "12 mm", "70 mm"])"}}});
  struck.push_back({"[[tool]]",
                    {{"shape", R"("sphere")"},
                     {"at", R"(["2 mm", "12 mm", "-9 mm"])"},
                     {"radius", R"("2 mm")"},
                     {"mass", R"("5 g")"},
                     {"free", R"(["z", "turn y"])"},
                     {"angular_velocity", R"(["0 rad/s", "60 rpm", "0 rad/s"])"}}});
  still.push_back({"[[load]]",
                   {{"acceleration", R"(["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"])"},
                    {"rate", R"(["0 m/s^3", "0 m/s^3", "-100 m/s^3"])"}}});
  still.push_back({"[[load]]",
                   {{"body_force", R"(["0 N/m^3", "1 kN/m^3", "0 N/m^3"])"},
                    {"history", R"([["0 s", 0], ["10 s", 1]])"}}});
  still.push_back({"[[load]]",
                   {{"angular_velocity", R"("300 rad/s")"},
                    {"axis", "[0, 0, 1]"},
                    {"point", R"(["0 mm", "12 mm", "0 mm"])"}}});
  still.push_back({"[[boundary]]",
                   {{"on", R"("z-max")"},
                    {"traction", R"(["0 MPa", "0 MPa", "1 MPa"])"},
                    {"factor.along", R"("y")"},
                    {"factor.table", R"([["0 mm", -1], ["24.5 mm", 1]])"}}});
  still.push_back({"[[initial.stress]]",
                   {{"along", R"("x")"}, {"surface", R"("-80 MPa")"}, {"components", R"(["y", "z"])"}}});
  still.push_back({"[[initial.stress]]",
                   {{"along", R"("x")"},
                    {"profile", R"([["0 mm", "-3 MPa"], ["2.5 mm", "3 MPa"], ["5 mm", "-3 MPa"]])"}}});
  still.push_back({"[[initial.stress]]",
                   {{"along", R"("y")"},
                    {"temperature", R"([["0 mm", "-200 K"], ["5 mm", "0 K"]])"},
                    {"expansion", R"("8e-6 1/K")"},
                    {"history", R"([["0 s", 0], ["10 s", 1]])"}}});
  return all;
}

/// An input file made from an echo.
std::string input_from_echo(const std::string& echo) {
  std::string text;
  std::string table;
  std::istringstream lines(echo);
  for (std::string line; std::getline(lines, line);) {
    const auto equals = line.find(" = ");
    std::string key = line.substr(0, equals);
    key.erase(key.find_last_not_of(' ') + 1);
    const std::string name =
        key.substr(key.find('.', key.find(']') == std::string::npos ? 0 : key.find(']')) + 1);
    const std::string path = key.substr(0, key.size() - name.size() - 1);
    if (path != table) {
      const auto bracket = path.find('[');
      text += bracket == std::string::npos ? "[" + path + "]\n" : "[[" + path.substr(0, bracket) + "]]\n";
      table = path;
    }
    text += name;
    text += " = " + as_written(line.substr(equals + 3)) + "\n";
  }
  return text;
}

TEST(InputEcho, IsACompleteDescription) {
  for (const auto& tables :
       {full_tables(), minimal_tables(), plates()[0], plates()[1], regions(), loads()[0], loads()[1]}) {
    const std::string echo = input::echo(parse_tables(tables));
    std::printf("%s\n", echo.c_str());
    const auto again = input::parse(input_from_echo(echo), "echo.toml");
    EXPECT_EQ(input::echo(again), echo);
  }
}

TEST(InputEcho, KeepsTheValues) {
  const auto p = parse_tables(full_tables());
  const auto again = input::parse(input_from_echo(input::echo(p)), "echo.toml");
  const auto expect_near = [](double a, double b) { EXPECT_NEAR(a, b, 1e-9 * std::abs(b)); };
  expect_near(again.materials[0].youngs_modulus, 210e9);
  expect_near(again.fracture.impulse, 2.5e-7 * 1e9);
  EXPECT_EQ(again.fracture.release_time, 0);
  ASSERT_TRUE(again.fracture.variation);
  EXPECT_EQ(again.fracture.variation->of, input::Varies::toughness);
  expect_near(again.fracture.variation->modulus, 12.5);
  expect_near(again.fracture.variation->reference_volume, 2e-6);
  expect_near(again.fracture.variation->correlation_length, 1.7e-3);
  expect_near(again.specimen.notches.at(0).depth, 6.21e-3);
  expect_near(again.specimen.notches.at(1).height, 50e-6);
  expect_near(again.time.duration, 123e-6);
  expect_near(again.damping_rate(), 2500);
  expect_near(again.bulk_viscosity().linear, 0.06);
  expect_near(again.bulk_viscosity().quadratic, 1.2);
  EXPECT_EQ(again.boundaries.at(5).kind, input::BoundaryKind::absorbing);
  ASSERT_EQ(again.mesh.regions.size(), 2U);
  expect_near(again.mesh.regions[0].box[2].second, 80e-3);
  expect_near(again.mesh.regions[0].spacing, 0.31e-3);
  EXPECT_EQ(again.mesh.regions[1].box[0], plane::unbounded);
  expect_near(again.mesh.regions[1].box[2].first, 20e-3);
  expect_near(again.boundaries.at(1).region[1].first, -1e-3);
  expect_near(again.boundaries.at(1).rate[1], 1e-3);
  expect_near(again.boundaries.at(2).value[1], 3e3);
  expect_near(again.boundaries.at(2).history.at(1).first, 0.02);
  expect_near(again.boundaries.at(3).value[1], 2e-3);
  expect_near(again.boundaries.at(4).rate[0], 3e-6);
  EXPECT_EQ(again.boundaries.at(4).components, p.boundaries.at(4).components);
  EXPECT_EQ(again.seed, 2012U);
  ASSERT_EQ(again.sections.lines.size(), 2U);
  expect_near(again.sections.lines[0].to[0], 14.5e-3);
  expect_near(again.sections.lines[0].to[1], -1e-3);
  expect_near(again.sections.lines[1].from[1], 3e-3);
  EXPECT_EQ(again.ensemble.plan, p.ensemble.plan);
  EXPECT_EQ(again.ensemble.replicates, 3);
  ASSERT_EQ(again.random.size(), 3U);
  EXPECT_EQ(again.random[2].key, "boundary[1].rate[2]");
  expect_near(again.random[1].lower, 1e-8 * std::pow(1e6, 1.5));
}

TEST(InputEcho, AnOwnBaseMakesOtherSamples) {
  const auto with = [](const std::string& base) { return parse_with("[mesh]", "base", base); };
  const auto minimal = parse_tables(minimal_tables());
  EXPECT_THAT(input::sample_settings(minimal), ::testing::Contains("mesh.base = own"));
  EXPECT_EQ(input::sample_identity(with(R"("own")")), input::sample_identity(minimal));
  EXPECT_NE(input::sample_identity(with(R"("shared")")), input::sample_identity(minimal));
}

TEST(InputEcho, AnotherEngineMakesOtherSamples) {
  const auto with = [](const std::string& engine) { return parse_with("[time]", "engine", engine); };
  const auto minimal = parse_tables(minimal_tables());
  EXPECT_THAT(input::sample_settings(minimal), ::testing::Contains("time.engine = fixed-point"));
  EXPECT_THAT(input::sample_settings(with(R"("petsc")")),
              ::testing::IsSupersetOf({"time.engine = petsc", "time.precision = double"}));
  EXPECT_EQ(input::sample_identity(with(R"("fixed-point")")), input::sample_identity(minimal));
  EXPECT_NE(input::sample_identity(with(R"("petsc")")), input::sample_identity(minimal));
  EXPECT_EQ(input::bits_notice(minimal.time.engine), "");
  EXPECT_EQ(input::bits_notice(with(R"("petsc")").time.engine),
            "engine petsc: a sample has the same bits on the same number of ranks only");
}

TEST(InputEcho, TheIdentityIsThatOfFilesFromBeforeSomeKeys) {
  const auto minimal = parse_with("[mesh]", "base", R"("shared")");
  auto settings = input::sample_settings(minimal);
  EXPECT_EQ(std::erase(settings, "mesh.base = shared") + std::erase(settings, "time.engine = fixed-point"),
            2U);
  std::ranges::replace(settings, std::string("mesh.symmetry = random"), std::string("mesh.turn = random"));
  std::ranges::replace(settings, std::string("fracture.accumulation = cumulative"),
                       std::string("fracture.memory = cumulative"));
  EXPECT_EQ(input::sample_identity(minimal),
            fmt::format("FNV-1a {:016x}", checksum(fmt::format("{}", fmt::join(settings, "\n")))));
}

/// It must not change when a law that an input does not use gets new keys.
TEST(InputEcho, TheIdentityHasTheKeysOfTheLawThatIsAskedFor) {
  const auto mentions = [](const input::Parameters& parameters, const std::string& key) {
    return std::ranges::any_of(input::sample_settings(parameters),
                               [&](const std::string& line) { return line.starts_with(key); });
  };
  auto parameters = parse_tables(minimal_tables());
  for (const char* key : {"fracture.softening", "fracture.teeth", "fracture.length"})
    EXPECT_FALSE(mentions(parameters, key)) << key;
  parameters.fracture.release = input::Release::softening;
  parameters.fracture.length = 1e-3;
  for (const char* key : {"fracture.softening", "fracture.teeth", "fracture.length"})
    EXPECT_TRUE(mentions(parameters, key)) << key;
}

TEST(InputEcho, ShowsReadableUnitsInAlignedLines) {
  const std::string echo = input::echo(parse_tables(full_tables()));
  std::set<std::size_t> columns;
  std::istringstream lines(echo);
  for (std::string line; std::getline(lines, line);) columns.insert(line.find(" = "));
  EXPECT_EQ(columns.size(), 1U);
  for (const char* shown : {"= 1.25 mm\n", "= 0.3 mm\n", "= 210 GPa\n", "= 350 MPa\n", "= 5 ns\n",
                            "= 123 us\n", "= 2.5e-07 MPa^1.5 s\n", "= [5 mm, 24.5 mm, 140 mm]\n",
                            "= [[0 s, 0], [20 ms, 1.25], [3 s, -2]]\n", "= [free, 2 mm/s, free]\n"}) {
    EXPECT_THAT(echo, ::testing::HasSubstr(shown));
  }
}

/// Which meshes cases share, which samples a folder may keep and what may be random follow from this.
TEST(InputEcho, EveryKeySaysWhatItAffects) {
  constexpr std::array words{"run",  "layers",    "draws",      "body",   "points",  "place",
                             "mesh", "materials", "conditions", "sample", "records", "reading"};
  std::string table_of_effects;
  for (const input::Table& table : input::schema()) {
    table_of_effects += table.path + ":";
    std::string before;
    for (const input::Key& key : table.keys) {
      const std::string word = words.at(static_cast<std::size_t>(key.affects));
      if (word != before) table_of_effects += (before.empty() ? " " : "; ") + word;
      before = word;
      table_of_effects += " " + key.name;
    }
    table_of_effects += "\n";
  }
  EXPECT_EQ(table_of_effects,
            R"(ensemble: layers samples; points seed; run ranks_per_sample meshes; draws plan replicates
ensemble.stop: run half_width confidence min_samples
specimen: body size thickness outline radius; run solid; body unit
specimen.hole: body center radius semi_axes angle polygon
specimen.notch: body face at depth height from to end
specimen.crack: body from to polygon center semi_axes normal
specimen.region: body material x y z center radius semi_axes angle polygon
mesh: points spacing notch_spacing growth; mesh perturbation; points min_quality; mesh symmetry; points base; run points
mesh.region: points x y z spacing
material: materials name; sample youngs_modulus poisson_ratio density strength toughness fracture_toughness impulse release_time release_speed
material.variation: sample of distribution modulus coefficient_of_variation correlation_length with_strength
material.map: materials file dataset of axes origin spacing scale checksum
interface: materials between; sample strength toughness
fracture: sample strength toughness fracture_toughness length exponent impulse accumulation release release_time release_speed nucleation softening teeth contact
fracture.variation: sample of distribution modulus reference_volume coefficient_of_variation correlation_length
boundary: place on; points region.x region.y region.z; conditions fix force traction velocity displacement pressure absorbing rate history factor.along factor.table name
load: conditions acceleration body_force angular_velocity axis point velocity velocity_gradient center rate history
tool: conditions name; points shape at axis radius; conditions size rounding mass displacement velocity angular_velocity force rate history free friction
initial.stress: conditions along surface profile components temperature expansion material history
time: sample start step mass_scaling duration integrator engine precision arrest after_separation
damping: sample mass bulk
contact: sample friction stiffness
sections: reading y z
sections.line: reading from to
sections.plane: reading point normal
output: records frames history governing branch_length
output.probe: records name at
random: draws key together distribution mean standard_deviation lower upper mode scale shape values weights
random.flaws: materials number density size direction region.x region.y region.z
correlation: draws between rank
sweep: sample key values
)");
}

/// The keys of the list, as "table.key".
std::set<std::string> listed_keys() {
  std::set<std::string> keys;
  std::string table;
  std::istringstream lines(input::key_list());
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("**")) {
      const auto first = line.find_first_not_of("*`[");
      table = line.substr(first, line.find(']') - first);
      continue;
    }
    // "- `x`, `y` (...": what is in backquotes before the bracket.
    std::istringstream names(line.substr(0, line.find(" (")));
    for (std::string name; std::getline(names, name, '`') && std::getline(names, name, '`');)
      keys.insert(table + "." + name);
  }
  return keys;
}

/// A box with cracks from the start.
std::vector<InputTable> cracks() {
  auto tables = full_tables();
  tables.push_back(
      {"[[random.flaws]]",
       {{"number", "3"},
        {"size", R"({ distribution = "weibull", shape = 3, scale = "3 mm" })"},
        {"direction", R"({ normal = [0, 0, 1], spread = "20 degree" })"},
        {"region", R"({ x = ["1 mm", "4 mm"], y = ["1 mm", "20 mm"], z = ["13 mm", "41 mm"] })"}}});
  tables.push_back({"[[random.flaws]]",
                    {{"density", R"("0.1 cm-3")"}, {"size", R"("3 mm")"}, {"direction", "[0, 1, 1]"}}});
  tables.push_back(
      {"[[specimen.crack]]", {{"from", R"(["0 mm", "70 mm"])"}, {"to", R"(["5 mm", "72 mm"])"}}});
  tables.push_back(
      {"[[specimen.crack]]",
       {{"polygon",
         R"([["1 mm", "5 mm", "30 mm"], ["4 mm", "5 mm", "30 mm"], ["4 mm", "9 mm", "30 mm"]])"}}});
  tables.push_back({"[[specimen.crack]]",
                    {{"center", R"(["2 mm", "12 mm", "50 mm"])"},
                     {"semi_axes", R"(["2 mm", "3 mm"])"},
                     {"normal", "[0, 0.5, 1]"}}});
  tables.push_back(
      {"[[sections.plane]]", {{"point", R"(["2 mm", "12 mm", "50 mm"])"}, {"normal", "[1, 0, 0]"}}});
  tables.push_back({"[contact]", {{"friction", "0.35"}, {"stiffness", "0.4"}}});
  const std::pair<std::string, std::string> at{"at", R"(["2 mm", "12 mm", "-9 mm"])"};
  tables.push_back({"[[tool]]",
                    {{"name", "\"punch\""},
                     {"shape", "\"cylinder\""},
                     at,
                     {"axis", "[0, 0, 1]"},
                     {"radius", "\"3 mm\""},
                     {"size", R"(["8 mm"])"},
                     {"rounding", "\"1 mm\""},
                     {"mass", "\"5 g\""},
                     {"force", R"(["0 N", "0 N", "2 N"])"},
                     {"rate", R"(["0 N/s", "0 N/s", "1 N/s"])"},
                     {"free", R"(["z"])"},
                     {"friction", "0.2"}}});
  tables.push_back({"[[tool]]",
                    {{"shape", "\"box\""},
                     at,
                     {"size", R"(["2 mm", "3 mm", "4 mm"])"},
                     {"displacement", R"(["0 mm", "0 mm", "1 mm"])"},
                     {"history", R"([["0 s", 0], ["1 s", 1]])"}}});
  tables.push_back({"[[tool]]",
                    {{"shape", "\"sphere\""},
                     at,
                     {"radius", "\"2 mm\""},
                     {"velocity", R"(["0 m/s", "0 m/s", "3 m/s"])"}}});
  return tables;
}

TEST(InputEcho, ShowsCracksFromTheStartAndContact) {
  const std::string echo = input::echo(parse_tables(cracks()));
  for (const char* const line :
       {"specimen.crack[0].to                  = [5 mm, 72 mm]",
        "specimen.crack[2].normal              = [0, 0.5, 1]",
        "random.flaws[0].size                  = {distribution = weibull, scale = 3 mm, shape = 3}",
        "random.flaws[0].direction             = {normal = [0, 0, 1], spread = ",
        "random.flaws[1].direction             = [0, 1, 1]",
        "sections.plane[0].normal              = [1, 0, 0]", "contact.friction                      = 0.35",
        "tool[0].mass                          = 5 g",
        "tool[1].size                          = [2 mm, 3 mm, 4 mm]",
        "tool[2].velocity                      = [0 m/s, 0 m/s, 3 m/s]"})
    EXPECT_NE(echo.find(line), std::string::npos) << line << " is not in\n" << echo;
}

TEST(InputEcho, AndListOfKeysNameTheSameKeys) {
  std::set<std::string> shown;
  std::istringstream lines(input::echo(parse_tables(cracks())) + input::echo(parse_tables(plates()[0])) +
                           input::echo(parse_tables(plates()[1])) + input::echo(parse_tables(regions())) +
                           input::echo(parse_tables(loads()[0])) + input::echo(parse_tables(loads()[1])));
  for (std::string line; std::getline(lines, line);) {
    std::string key = line.substr(0, line.find(' '));
    const auto open = key.find('[');
    if (open != std::string::npos) key.erase(open, key.find(']') - open + 1);
    shown.insert(key);
  }
  for (const char* unused : {"ensemble.stop.half_width",
                             "ensemble.stop.confidence",
                             "ensemble.stop.min_samples",
                             "mesh.points",
                             "fracture.toughness",
                             "fracture.fracture_toughness",
                             "fracture.length",
                             "fracture.softening",
                             "fracture.release_speed",
                             "fracture.teeth",
                             "fracture.variation.coefficient_of_variation",
                             "material.toughness",
                             "material.fracture_toughness",
                             "material.release_time",
                             "material.variation.coefficient_of_variation",
                             "interface.toughness",
                             "initial.stress.material",
                             "material.release_speed",
                             "output.branch_length",
                             "random.together",
                             "random.values",
                             "random.weights",
                             "correlation.between",
                             "correlation.rank",
                             "time.after_separation",
                             "time.mass_scaling",
                             "specimen.solid",
                             "specimen.unit",
                             "sweep.key",
                             "sweep.values"}) {
    shown.insert(unused);
  }
  const auto declared = listed_keys();
  std::printf("%zu keys\n", declared.size());
  EXPECT_EQ(shown, declared);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::test
