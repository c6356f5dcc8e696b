// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/experiments_file.h"

#include "crackle/common/quantity_text.h"
#include "crackle/experiment/path_frame.h"
#include "crackle/input/reader.h"
#include "csv_table.h"
#include "experiment_keys.h"
#include "input/dimension.h"
#include "input/document.h"
#include "input/table.h"
#include "input/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace crackle::experiment {

namespace {

/// A place in the experiment's axes, in those of the body.
plane::Point in_body(const Draft& draft, const plane::Point& p) {
  const double y = draft.mirror == Mirror::y ? -p[0] : p[0];
  const double z = draft.mirror == Mirror::z ? -p[1] : p[1];
  const double c = std::cos(draft.angle), s = std::sin(draft.angle);
  return {draft.origin[0] + c * y - s * z, draft.origin[1] + s * y + c * z};
}

const QuantityColumn y_column{"y", &input::length_dimension};
const QuantityColumn z_column{"z", &input::length_dimension};
const QuantityColumn time_column{"time", &input::time_dimension};
const QuantityColumn displacement_column{"displacement", &input::length_dimension};
const QuantityColumn strength_column{"strength", &input::stress_dimension};

QuantityColumn load_column(const char* name) {
  return {name, &input::value_dimension(input::BoundaryKind::force)};
}

/// Reads the CSV file of a key by `read(table, errors)` and reports all its errors there.
template <class Read>
void read_file(const std::string& name, const std::string& key, input::Context& context, const Read& read) {
  const std::filesystem::path file = context.folder / name;
  CsvErrors errors;
  const CsvTable table = read_csv(file, errors);
  if (errors.empty()) read(table, errors);
  for (const std::string& error : errors.errors)
    context.findings.report(key, "{}: {}", input::shortened(file.string(), 200), error);
}

/// The columns, all of which are needed; empty if any of them is missing or has an error.
std::vector<std::vector<double>> needed_columns(const CsvTable& table,
                                                const std::vector<QuantityColumn>& columns,
                                                const std::string& example, std::size_t n_rows,
                                                CsvErrors& errors) {
  std::vector<std::vector<double>> values;
  for (const QuantityColumn& column : columns) {
    auto read = read_column(table, column, errors);
    if (!read) errors.add(0, fmt::format("has no column {}; give a header such as {}", column.name, example));
    values.push_back(std::move(read).value_or(std::vector<double>{}));
  }
  if (errors.empty() && table.rows.size() < n_rows)
    errors.add(0, fmt::format("has {}; give at least {}", count_text(table.rows.size(), "row"), n_rows));
  if (!errors.empty()) values.clear();
  return values;
}

void refuse_negative(const CsvTable& table, std::span<const double> values, const char* reason,
                     CsvErrors& errors) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] < 0) errors.add(table.rows[i].line, reason);
}

constexpr const char* negative_time = "the time is below 0; times count from when the crack began to run";
constexpr const char* negative_load = "negative load; loads are positive in the machine's direction";

void add_path(Draft& draft, const CsvTable& table, CsvErrors& errors) {
  const auto columns = needed_columns(table, {y_column, z_column}, "y_mm,z_mm", 2, errors);
  if (columns.empty()) return;
  const auto arm = table.column("arm");
  std::vector<std::string> arms;  // in the order in which they begin
  std::vector<Polyline>& lines = draft.experiment.lines;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const CsvTable::Row& row = table.rows[i];
    const std::string name = fmt::format("{}", arm ? row.cells[*arm] : std::to_string(row.block));
    const auto found = std::ranges::find(arms, name) - arms.begin();
    if (found == std::ssize(arms)) {
      arms.push_back(name);
      lines.emplace_back();
    }
    Polyline& line = lines[static_cast<std::size_t>(found)];
    const plane::Point p = in_body(draft, {columns[0][i], columns[1][i]});
    if (line.empty() || line.back() != p) line.push_back(p);
  }
  for (std::size_t k = 0; k < lines.size(); ++k)
    if (lines[k].size() < 2)
      errors.add(0, fmt::format("arm {} has a single point; give at least two of each",
                                arm ? arms[k] : std::to_string(k + 1)));
  if (errors.empty() && draft.experiment.path_error_length == 0)
    draft.experiment.path_error_length =
        length_of(lines.front()) / static_cast<double>(lines.front().size() - 1);
}

void add_tips(Draft& draft, const CsvTable& table, CsvErrors& errors) {
  const auto columns =
      needed_columns(table, {time_column, y_column, z_column}, "time_us,y_mm,z_mm", 1, errors);
  if (columns.empty()) return;
  refuse_negative(table, columns[0], negative_time, errors);
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    draft.experiment.tips.push_back({columns[0][i], in_body(draft, {columns[1][i], columns[2][i]})});
}

void add_curve(Draft& draft, const CsvTable& table, CsvErrors& errors) {
  auto columns =
      needed_columns(table, {displacement_column, load_column("load")}, "displacement_mm,load_N", 2, errors);
  if (columns.empty()) return;
  Experiment& experiment = draft.experiment;
  if (std::ranges::max(columns[1]) < 0)
    errors.add(0, "all loads are below 0; they count along the machine's drive");
  experiment.curve = {std::move(columns[0]), std::move(columns[1])};
  if (!experiment.peak_load) experiment.peak_load = *std::ranges::max_element(experiment.curve.load);
}

std::vector<Experiment> rows_of_loads(const Draft& draft, const CsvTable& table, CsvErrors& errors) {
  auto peak = read_column(table, load_column("peak_load"), errors);
  const auto onset = read_column(table, load_column("onset_load"), errors);
  if (const auto strength = read_column(table, strength_column, errors)) {
    if (peak)
      errors.add(0, "has both peak_load and strength; leave one of them out");
    else if (draft.load_per_strength == 0)
      errors.add(0, "has strengths; give load_per_strength too, the load over the strength");
    peak = *strength;
    for (double& value : *peak) value *= draft.load_per_strength;
  }
  for (const auto& loads : {peak, onset})
    if (loads) refuse_negative(table, *loads, negative_load, errors);
  if (!peak && !onset && errors.empty())
    errors.add(0, "has no column peak_load, onset_load or strength; give a header such as peak_load_N");
  if (table.rows.empty()) errors.add(0, "has no rows");
  std::vector<Experiment> experiments;
  if (!errors.empty()) return experiments;
  const auto name = table.column("name");
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    Experiment experiment = draft.experiment;
    const std::string of_row =
        name ? input::shortened(table.rows[i].cells[*name]) : fmt::format("row {}", i + 1);
    experiment.name = experiment.name.empty() ? of_row : fmt::format("{} {}", experiment.name, of_row);
    if (peak) experiment.peak_load = (*peak)[i];
    if (onset) experiment.onset_load = (*onset)[i];
    experiments.push_back(std::move(experiment));
  }
  return experiments;
}

/// Sets where the picture's pixels are in the body.
void place_picture(const Draft& draft, Picture& picture) {
  const auto place = [&](double from_left, double from_top) {
    return in_body(draft, {picture.scale * (from_left - picture.origin[0]),
                           picture.scale * (picture.origin[1] - from_top)});
  };
  picture.corner = place(0, 0);
  picture.right = place(1, 0) - picture.corner;
  picture.down = place(0, 1) - picture.corner;
}

/// Completes the experiment by its files of path, tips and curve. Errors are reported at their keys.
/// @param prefix of the keys in messages: "experiment[0]."
void add_files(Draft& draft, const std::string& prefix, input::Context& context) {
  using Add = void (*)(Draft&, const CsvTable&, CsvErrors&);
  const auto read = [&](const char* key, const std::string& file, Add add) {
    if (file.empty()) return;
    read_file(file, prefix + key, context,
              [&](const CsvTable& table, CsvErrors& errors) { add(draft, table, errors); });
  };
  read("path", draft.path, add_path);
  read("tips", draft.tips, add_tips);
  read("curve", draft.curve, add_curve);
}

/// An experiment for each row of the file of loads.
std::vector<Experiment> experiments_of_loads(const Draft& draft, const std::string& prefix,
                                             input::Context& context) {
  std::vector<Experiment> experiments;
  read_file(draft.loads, prefix + "loads", context, [&](const CsvTable& table, CsvErrors& errors) {
    experiments = rows_of_loads(draft, table, errors);
  });
  return experiments;
}

using input::Findings;
using input::Value;

/// The tables of an array inside the table of an experiment.
template <class Part>
std::vector<Part> read_parts(const input::BasicTable<Part>& table, const Value& experiment,
                             const std::string& key, input::Context& context) {
  std::vector<Part> parts;
  const std::string name = table.path.substr(table.path.rfind('.') + 1);
  const Value* const given = experiment.find(name);
  if (given == nullptr || given->kind != input::ValueKind::array) return parts;
  for (std::size_t i = 0; i < given->elements.size(); ++i) {
    if (given->elements[i].kind != input::ValueKind::table) continue;
    read_table(table, given->elements[i], fmt::format("{}.{}[{}]", key, name, i), parts.emplace_back(), i,
               context);
  }
  return parts;
}

/// Keys that say something about another one, which is missing.
void check_companions(const std::string& key, const Findings& findings, Findings& reports) {
  const auto given = [&](const char* name) { return findings.given(key + "." + name); };
  const auto needs = [&](const char* name, bool has, const char* wanted) {
    if (given(name) && !has)
      reports.report(fmt::format("{}.{}", key, name), "is for {}; give that, or leave it out", wanted);
  };
  const bool has_load = given("onset_load") || given("peak_load") || given("loads") || given("curve");
  const bool has_tip = given("tip") || given("tips");
  needs("path_error", given("path"), "path");
  needs("path_error_length", given("path_error"), "path_error");
  needs("arrested", given("path"), "path");
  needs("load_error", has_load, "a load");
  needs("load_per_strength", given("loads"), "loads");
  needs("time_error", has_tip, "tip or tips");
  if (!given("loads")) return;
  for (const char* name : {"path", "onset_load", "peak_load", "tip", "tips", "curve", "picture"})
    if (given(name))
      reports.report(
          fmt::format("{}.{}", key, name),
          "does not go with loads, each of which is an experiment; give it in an [[experiment]] of "
          "its own");
}

void check_observed(const Experiment& experiment, const std::string& key, Findings& findings) {
  const bool has_any = findings.given(key + ".path") || findings.given(key + ".onset_load") ||
                       findings.given(key + ".peak_load") || findings.given(key + ".curve") ||
                       findings.given(key + ".loads") || findings.given(key + ".tips") ||
                       !experiment.tips.empty() || !experiment.pictures.empty();
  if (has_any || findings.faulty(key)) return;
  findings.report(key,
                  "nothing was observed in this experiment; give path, onset_load, peak_load, loads, curve, "
                  "tips, [[experiment.tip]] or [[experiment.picture]]");
}

void check_names(const std::vector<Experiment>& experiments, Findings& findings) {
  std::set<std::string> names;
  for (const Experiment& experiment : experiments)
    if (!experiment.name.empty() && !names.insert(experiment.name).second)
      findings.report("experiment", "two experiments are named \"{}\"; give each its own name",
                      experiment.name);
}

std::vector<input::KnownTable> known_tables() {
  return {names_in(top_table()), names_in(experiment_table()), names_in(tip_table()),
          names_in(picture_table())};
}

void read_experiment(const Value& value, const std::string& key, input::Context& context,
                     std::vector<Experiment>& experiments) {
  Draft draft;
  read_table(experiment_table(), value, key, draft, 0, context);
  const auto tips = read_parts(tip_table(), value, key, context);
  draft.experiment.pictures = read_parts(picture_table(), value, key, context);
  check_companions(key, context.findings, context.findings);
  for (Picture& picture : draft.experiment.pictures) place_picture(draft, picture);
  for (const Tip& tip : tips) draft.experiment.tips.push_back({tip.time, in_body(draft, tip.at)});
  check_observed(draft.experiment, key, context.findings);
  add_files(draft, key + ".", context);
  if (draft.loads.empty()) return experiments.push_back(std::move(draft.experiment));
  for (Experiment& row : experiments_of_loads(draft, key + ".", context))
    experiments.push_back(std::move(row));
}

std::vector<Experiment> read_document(const Value& root, input::Context& context) {
  std::vector<Experiment> experiments;
  Draft top;
  read_table(top_table(), root, "", top, 0, context);
  for (const char* name : {"load_error", "load_per_strength"})
    if (context.findings.given(name) && top.loads.empty())
      context.findings.report(name, "is for loads; give that, or move it into its [[experiment]]");
  if (!top.loads.empty()) experiments = experiments_of_loads(top, "", context);
  const Value* const given = root.find("experiment");
  if (given != nullptr && given->kind == input::ValueKind::array) {
    for (std::size_t i = 0; i < given->elements.size(); ++i)
      if (given->elements[i].kind == input::ValueKind::table)
        read_experiment(given->elements[i], fmt::format("experiment[{}]", i), context, experiments);
  }
  if (experiments.empty() && context.findings.empty())
    context.findings.report("", "there is no experiment; give [[experiment]], or loads = \"loads.csv\"");
  check_names(experiments, context.findings);
  return experiments;
}

}  // namespace

std::vector<Experiment> read_experiments(const std::filesystem::path& file) {
  Findings findings;
  std::vector<Experiment> experiments;
  try {
    const std::string text = input::read_text_file(file, "an experiments file in TOML");
    const Value root = input::parse_document(text);
    const input::PointsFile no_points;
    input::Context context{input::UnitSystem::shared(), findings, file.parent_path(), no_points, &root};
    input::locate(root, "", findings);
    input::report_unknown_keys(root, known_tables(), findings);
    experiments = read_document(root, context);
  } catch (const input::SyntaxError& error) {
    findings.report("", error.line(), error.what());
  }
  if (!findings.empty()) throw input::InputError(findings.messages(file));
  return experiments;
}

std::vector<std::string> experiment_keys() {
  std::vector<std::string> keys;
  for (const input::KnownTable& table : known_tables())
    for (const std::string& key : table.keys) keys.push_back(table.path + "." + key);
  return keys;
}

std::string explained_experiment_keys(const std::vector<std::string>& skipped) {
  std::string text;
  for (const auto& key : experiment_table().keys)
    if (std::ranges::find(skipped, key.name) == skipped.end())
      text += input::commented_out(key.name, key.requirement, key.accepted, key.help);
  return text;
}

}  // namespace crackle::experiment
