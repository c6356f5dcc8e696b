// SPDX-License-Identifier: GPL-3.0-or-later
// [[sweep]]: keys whose values define the cases of a study.
#include "consistency.h"
#include "schema.h"
#include "settings.h"

#include <map>
#include <set>

namespace crackle::input {

namespace {

constexpr std::size_t max_cases = 1000;
/// Keys common to all cases of one run.
constexpr std::array same_for_all{"ensemble.ranks_per_sample", "ensemble.meshes"};

const std::string accepted_sweep_key =
    "the name of a key, such as \"mesh.perturbation\", or an array of names whose values change together";
const std::string accepted_sweep_values =
    "an array of values that the key could have, such as [0.05, 0.1, 0.2]; of several keys an array with one "
    "value for each, such as [[\"2 mm\", \"0.6 mm\"], [\"1 mm\", \"0.3 mm\"]]";

Sweep& sweep(Parameters& parameters, std::size_t i) {
  return parameters.sweeps.at(i);
}

void read_key(const Source& source, Sweep& sweep) {
  const auto path = read_text(source, accepted_sweep_key);
  if (!path) return;
  const bool is_known = find_key(*path) != nullptr && !path->starts_with("sweep");
  const bool is_common = std::ranges::find(same_for_all, *path) != same_for_all.end();
  if (!is_known)
    source.report("the input has no key \"{}\"; {}", shortened(*path),
                  advice_on_key(*path, accepted_sweep_key));
  else if (is_common)
    source.report("\"{}\" must be the same in all cases of a run; leave it out", *path);
  sweep.keys.push_back(*path);
}

/// One value in TOML.
void read_value(const Source& source, std::vector<std::string>& values) {
  if (is_plain(source.value))
    values.push_back(to_toml(source.value));
  else
    source.report("this contains {}; give {}", describe(source.value.kind), accepted_sweep_values);
}

Key sweep_key_key() {
  return {"key",
          "name, or names",
          required(),
          accepted_sweep_key,
          "named as in [[random]]",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            if (source.value.kind != ValueKind::array) return read_key(source, sweep(parameters, i));
            const auto names = read_elements(source, 0, accepted_sweep_key);
            if (!names) return;
            for (const Source& name : *names) read_key(name, sweep(parameters, i));
          },
          [](Parameters& parameters, std::size_t i) { return bracketed(sweep(parameters, i).keys); }};
}

Key sweep_values_key() {
  return {"values",
          "as the key",
          required(),
          accepted_sweep_values,
          "several [[sweep]] make all combinations",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            const auto cases = read_elements(source, 0, accepted_sweep_values);
            if (!cases) return;
            const std::size_t n_keys = sweep(parameters, i).keys.size();
            for (const Source& values : *cases) {
              auto& row = sweep(parameters, i).values.emplace_back();
              if (n_keys <= 1) {
                read_value(values, row);
              } else if (const auto row_values = read_elements(values, n_keys, accepted_sweep_values)) {
                for (const Source& value : *row_values) read_value(value, row);
              }
            }
          },
          [](Parameters& parameters, std::size_t i) {
            std::vector<std::string> rows;
            for (const auto& row : sweep(parameters, i).values)
              rows.push_back(row.size() == 1 ? row.front() : bracketed(row));
            return bracketed(rows);
          }};
}

std::size_t n_cases(const Parameters& parameters) {
  std::size_t n = 1;
  for (const Sweep& one : parameters.sweeps) n = std::min(n * one.values.size(), 2 * max_cases);
  return n;
}

}  // namespace

Table sweep_table() {
  return {"sweep",
          Occurrence::many,
          "a parameter study: crackle run computes an ensemble for each value",
          {sweep_key_key(), sweep_values_key()},
          [](const Parameters& parameters) { return parameters.sweeps.size(); },
          [](Parameters& parameters) { parameters.sweeps.emplace_back(); }};
}

void check_sweeps(const Parameters& parameters, Findings& findings) {
  std::set<std::string> keys;
  for (std::size_t i = 0; i < parameters.sweeps.size(); ++i)
    for (const std::string& key : parameters.sweeps[i].keys)
      if (!keys.insert(key).second)
        findings.report(fmt::format("sweep[{}].key", i), "\"{}\" is swept already; give each key once", key);
      else if (const auto instead = parameter_instead_of(key, parameters))
        findings.report(fmt::format("sweep[{}].key", i),
                        "\"{}\" is random too, with a distribution that takes nothing from it, so that all "
                        "cases would be the same; sweep the distribution, such as \"{}\"",
                        key, *instead);
  if (n_cases(parameters) > max_cases)
    findings.report("sweep", "there are more than {} cases; give fewer values", max_cases);
}

std::vector<std::string> sweep_warnings(const std::vector<Case>& cases) {
  std::map<std::string, std::vector<std::size_t>> equal;  // numbers of the cases with equal values
  for (std::size_t number = 0; number < cases.size(); ++number)
    equal[echo(cases[number].parameters)].push_back(number);
  std::vector<std::string> warnings;
  for (const auto& [values, numbers] : equal)
    if (numbers.size() > 1)
      warnings.push_back(fmt::format("cases {} of the sweep are identical, so their samples are too: {}",
                                     fmt::join(numbers, ", "), to_string(cases[numbers.front()].settings)));
  return warnings;
}

std::vector<Case> sweep_cases(const Parameters& parameters, const std::filesystem::path& name,
                              bool are_stored) {
  const std::string common = without_tables(parameters.text, "sweep");
  const std::size_t n = n_cases(parameters);
  std::vector<Case> cases;
  for (std::size_t number = 0; number < n; ++number) {
    Case one;
    bool has_points = false, has_solid = false;
    std::size_t rest = number;
    std::vector<std::vector<Setting>> parts;  // for each sweep, the last one first
    for (auto swept = parameters.sweeps.rbegin(); swept != parameters.sweeps.rend(); ++swept) {
      const auto& row = swept->values[rest % swept->values.size()];
      rest /= swept->values.size();
      auto& part = parts.emplace_back();
      for (std::size_t k = 0; k < swept->keys.size(); ++k) part.push_back({swept->keys[k], row[k]});
    }
    for (auto part = parts.rbegin(); part != parts.rend(); ++part)
      one.settings.insert(one.settings.end(), part->begin(), part->end());
    bool has_map = false;
    for (const Setting& setting : one.settings) {
      has_points = has_points || setting.key == "mesh.points";
      has_solid = has_solid || setting.key == "specimen.solid" || setting.key == "specimen.unit";
      has_map = has_map || setting.key == map_key(parameters) + ".file";
    }
    // At the end, so that line numbers match the file.
    std::vector<Setting> settings = one.settings;
    // Another raster has another checksum; that of results stands in the input of the case.
    if (has_map)
      settings.push_back(
          {map_key(parameters) + ".checksum", are_stored ? "\"in the input of the case\"" : "\"\""});
    const std::string text = with_settings(common, settings) +
                             fmt::format("\n# Case {} of {}: {}\n", number, n, to_string(one.settings));
    GivenFiles files = files_of(parameters);
    if (has_points) files.points_digest = files.points = "";
    // Results of stored cases are read without their bodies.
    if (has_solid && !are_stored) files.known_solid = nullptr;
    try {
      one.parameters = parse(text, name, files);
    } catch (const InputError& error) {
      std::vector<std::string> messages;
      for (const std::string& message : error.messages())
        messages.push_back(fmt::format("{} (in case {}: {})", message, number, to_string(one.settings)));
      throw InputError(messages);
    }
    cases.push_back(std::move(one));
  }
  return cases;
}

}  // namespace crackle::input
