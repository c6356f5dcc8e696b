// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/reader.h"

#include "consistency.h"
#include "document.h"
#include "findings.h"
#include "schema.h"
#include "settings.h"
#include "values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>

namespace crackle::input {

namespace {

/// Handles a table that is missing in the document.
void read_missing_table(const Table& table, Parameters& parameters, Context& context) {
  std::vector<std::string> needed;
  for (const Key& key : table.keys)
    if (key.requirement.required) needed.push_back(key.name);
  if (needed.empty()) return read_table(table, Value{}, table.path, parameters, 0, context);
  context.findings.report(table.path, "the table [{}] is missing; give it, with {}", table.path,
                          fmt::join(needed, ", "));
}

/// Reads the tables of an entry that is part of a table given several times.
void read_parts(const Table& table, const Value& wholes, Parameters& parameters, Context& context) {
  const std::string part = table.path.substr(table.part_of.size() + 1);
  for (std::size_t i = 0; i < wholes.elements.size(); ++i) {
    const Value* const value = find_path(wholes.elements[i], part);
    if (value != nullptr && value->kind == ValueKind::table)
      read_table(table, *value, numbered(table.path, table.part_of, i), parameters, i, context);
  }
}

/// Reads all tables of one entry of the schema.
void read_tables(const Table& table, const Value& root, Parameters& parameters, Context& context) {
  if (!table.part_of.empty())
    if (const Value* const wholes = find_path(root, table.part_of);
        wholes != nullptr && wholes->kind == ValueKind::array)
      return read_parts(table, *wholes, parameters, context);
  const Value* value = find_path(root, table.path);
  const bool is_list = value != nullptr && value->kind == ValueKind::array;
  if (table.occurrence == Occurrence::many || (table.occurrence == Occurrence::once_or_many && is_list)) {
    if (value == nullptr || value->kind != ValueKind::array) return;
    for (std::size_t i = 0; i < value->elements.size(); ++i) {
      // One of a table that must occur is there from the start.
      if (table.occurrence == Occurrence::many || i > 0) table.append(parameters);
      if (value->elements[i].kind != ValueKind::table) continue;
      read_table(table, value->elements[i], fmt::format("{}[{}]", table.path, i), parameters, i, context);
    }
  } else if (value != nullptr) {
    if (value->kind != ValueKind::table) return;
    if (table.append && table.occurrence != Occurrence::once_or_many) table.append(parameters);
    read_table(table, *value, table.path, parameters, 0, context);
  } else if (table.occurrence == Occurrence::once || table.occurrence == Occurrence::once_or_many) {
    read_missing_table(table, parameters, context);
  }
}

/// The text with the points of the outline in place of their file name, so that the input contains the whole
/// body.
/// @param name of the file, as in the document
/// @return empty if the name does not occur verbatim in the text
std::optional<std::string> with_outline(const std::string& text, const Value& name,
                                        const plane::Polygon& polygon) {
  std::size_t start = 0;
  for (int i = 1; i < name.line; ++i) start = text.find('\n', start) + 1;
  const std::size_t key = text.find("outline", start);
  const std::size_t first = text.find_first_of("\"'", text.find('=', key));
  if (first == std::string::npos) return {};
  const std::size_t last = text.find(text[first], first + 1);
  if (last == std::string::npos || text.substr(first + 1, last - first - 1) != name.string) return {};
  std::vector<std::string> points;
  for (const auto& [y, z] : polygon) points.push_back(fmt::format("[\"{} m\", \"{} m\"]", y, z));
  return text.substr(0, first) + fmt::format("[{}]", fmt::join(points, ", ")) + text.substr(last + 1);
}

/// The text with the values of random inputs in place of the names of files with them.
std::string with_random_values(std::string text, const Parameters& parameters,
                               const std::filesystem::path& name) {
  const Value root = parse_document(text);
  for (std::size_t i = 0; i < parameters.random.size(); ++i) {
    const RandomInput& random = parameters.random[i];
    const std::string key = fmt::format("random[{}].values", i);
    const Value* const given = find_path(root, key);
    if (given == nullptr || given->kind != ValueKind::string) continue;
    std::vector<std::string> values;
    for (const double value : random.values)
      values.push_back(random.unit.empty() ? fmt::format("{}", value)
                                           : fmt::format("\"{} {}\"", value, random.unit));
    try {
      text = with_settings(text, {{key, fmt::format("[{}]", fmt::join(values, ", "))}});
    } catch (const InputError&) {
      throw InputError(
          {fmt::format("{}: {}: give it in a table with the header [[random]]", name.string(), key)});
    }
  }
  return text;
}

/// The text with the checksum of the raster.
std::string with_map_checksum(const std::string& text, const Parameters& parameters,
                              const std::filesystem::path& name) {
  const std::string key = map_key(parameters);
  const Value root = parse_document(text);
  const Value* const given = find_path(root, key + ".checksum");
  if (given != nullptr && given->string == parameters.map->checksum) return text;
  try {
    return with_settings(text, {{key + ".checksum", fmt::format("\"{}\"", parameters.map->checksum)}});
  } catch (const InputError&) {
    throw InputError(
        {fmt::format("{}: {}: give it as a table with the header [material.map]", name.string(), key)});
  }
}

/// @param draw of a sample: random inputs have the drawn values. These need not be valid means of their
///   distributions, and sections may lie outside the reach of cracks.
/// @param drawn in place of those of the text
Parameters parse(const std::string& text, const std::filesystem::path& name, const GivenFiles& files,
                 std::optional<Draw> draw, const std::vector<Setting>& drawn) {
  Findings findings;
  Parameters parameters;
  std::string stored = text;
  try {
    Value root = parse_document(text);
    if (root.members.empty()) {
      throw SyntaxError(1, "the file has no keys; give an input file in TOML");
    }
    root = with_settings(std::move(root), drawn);
    Context context{UnitSystem::shared(), findings, name.parent_path(), files, &root};
    locate(root, "", findings);
    report_unknown_keys(root, known_tables(), findings);
    for (const Table& table : schema()) read_tables(table, root, parameters, context);
    const Value* const outline = find_path(root, "specimen.outline");
    if (outline != nullptr && outline->kind == ValueKind::string &&
        !parameters.specimen.outline->polygon.empty()) {
      if (const auto completed = with_outline(stored, *outline, parameters.specimen.outline->polygon))
        stored = *completed;
      else
        findings.report("specimen.outline", "give the file name in quotes, on the same line as the key");
    }
  } catch (const SyntaxError& error) {
    findings.report("", error.line(), error.what());
    throw InputError(findings.messages(name));
  }
  parameters.draw = std::move(draw);
  if (parameters.mesh.notch_spacing == 0) parameters.mesh.notch_spacing = parameters.mesh.spacing;
  complete_specimen(parameters, findings);
  check_cracks(parameters, findings);
  complete_fracture(parameters, findings);
  check_specimen(parameters, findings);
  complete_regions(parameters, findings);
  complete_map(parameters, findings);
  for (const auto check : {check_materials, check_mesh, check_stop, check_sections, check_fracture,
                           check_boundaries, check_loads, check_tools, check_contact, check_initial_stresses,
                           check_time, check_output, check_sweeps})
    check(parameters, findings);
  if (!parameters.draw) check_random(parameters, findings);
  if (!findings.empty()) throw InputError(findings.messages(name));
  if (parameters.time.engine == Engine::petsc) parameters.time.precision = Precision::double_;
  // The stored input names the contents of the raster, which may no longer be there when it is read again.
  if (parameters.map) stored = with_map_checksum(stored, parameters, name);
  parameters.text = with_random_values(std::move(stored), parameters, name);
  parameters.notes = findings.notes(name);
  return parameters;
}

}  // namespace

std::string numbered(const std::string& path, const std::string& of, std::size_t i) {
  return fmt::format("{}[{}]{}", of, i, path.substr(of.size()));
}

void locate(const Value& value, const std::string& key, Findings& findings) {
  if (!key.empty()) findings.locate(key, value.line);
  for (const Member& member : value.members) {
    locate(member.value, key.empty() ? member.name : key + "." + member.name, findings);
  }
  for (std::size_t i = 0; i < value.elements.size(); ++i) {
    locate(value.elements[i], fmt::format("{}[{}]", key, i), findings);
  }
}

std::string read_text_file(const std::filesystem::path& file, const std::string& wanted) {
  const auto fail = [&](const std::string& reason) {
    throw InputError({fmt::format("{}: {}; give {}", file.string(), reason, wanted)});
  };
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) fail("there is no such file");
  if (std::filesystem::is_directory(status)) fail("is a directory");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail(fmt::format("cannot be read ({})", std::strerror(errno)));
  std::string text(max_text_size + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) fail("cannot be read to the end");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

InputError::InputError(std::vector<std::string> messages)
    : std::runtime_error(fmt::format("{}", fmt::join(messages, "\n"))), messages_(std::move(messages)) {}

GivenFiles files_of(const Parameters& parameters) {
  return {.points = parameters.mesh.points.value_or(std::filesystem::path()),
          .points_digest = parameters.mesh.points_digest,
          .known_solid = parameters.specimen.solid};
}

Parameters parse(const std::string& text, const std::filesystem::path& name, const GivenFiles& files) {
  return parse(text, name, files, std::nullopt, {});
}

Parameters drawn(const Parameters& parameters, const std::vector<double>& values, const std::string& name) {
  std::vector<Setting> settings;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const RandomInput& random = parameters.random[i];
    const auto set = [&](const std::string& key, double value, const std::string& unit) {
      settings.push_back(
          {key, unit.empty() ? fmt::format("{}", value) : fmt::format("\"{} {}\"", value, unit)});
    };
    set(random.key, values[i], random.unit);
    for (const MovedNumber& moved : random.moved)
      set(moved.key,
          random.by_factor ? moved.own * (values[i] / random.own) : moved.own + (values[i] - random.own),
          moved.unit);
  }
  Parameters result =
      parse(parameters.text, name, files_of(parameters), Draw{values, sample_settings(parameters)}, settings);
  // Slots that meet are one, from which other cracks begin than from two.
  if (is_box(result.specimen) != is_box(parameters.specimen))
    throw InputError(
        {fmt::format("specimen.notch: slots meet {}; draw places where all samples have the same slots",
                     is_box(parameters.specimen) ? "here, but not with the values of the input"
                                                 : "with the values of the input, but not here")});
  if (result.map) result.map->folder = parameters.map->folder;
  result.random = parameters.random;
  result.correlations = parameters.correlations;
  return result;
}

Parameters read(const std::filesystem::path& file, const GivenFiles& files) {
  return parse(read_text_file(file, "an input file in TOML"), file, files);
}

}  // namespace crackle::input
