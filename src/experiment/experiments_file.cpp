// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/experiments_file.h"

#include "crackle/input/reader.h"
#include "experiment_keys.h"
#include "experiment_parts.h"
#include "input/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace crackle::experiment {

namespace {

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
