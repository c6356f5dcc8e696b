// SPDX-License-Identifier: GPL-3.0-or-later
#include "experiment_parts.h"

#include "crackle/common/quantity_text.h"
#include "crackle/experiment/path_frame.h"
#include "csv_table.h"
#include "input/dimension.h"
#include "input/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

namespace crackle::experiment {

namespace {

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

}  // namespace

plane::Point in_body(const Draft& draft, const plane::Point& p) {
  const double y = draft.mirror == Mirror::y ? -p[0] : p[0];
  const double z = draft.mirror == Mirror::z ? -p[1] : p[1];
  const double c = std::cos(draft.angle), s = std::sin(draft.angle);
  return {draft.origin[0] + c * y - s * z, draft.origin[1] + s * y + c * z};
}

void place_picture(const Draft& draft, Picture& picture) {
  const auto place = [&](double from_left, double from_top) {
    return in_body(draft, {picture.scale * (from_left - picture.origin[0]),
                           picture.scale * (picture.origin[1] - from_top)});
  };
  picture.corner = place(0, 0);
  picture.right = place(1, 0) - picture.corner;
  picture.down = place(0, 1) - picture.corner;
}

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

std::vector<Experiment> experiments_of_loads(const Draft& draft, const std::string& prefix,
                                             input::Context& context) {
  std::vector<Experiment> experiments;
  read_file(draft.loads, prefix + "loads", context, [&](const CsvTable& table, CsvErrors& errors) {
    experiments = rows_of_loads(draft, table, errors);
  });
  return experiments;
}

}  // namespace crackle::experiment
