// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/ensemble_file.h"

#include "analysis/result_list.h"
#include "common/failure.h"
#include "common/regular_file.h"
#include "hdf5.h"
#include "provenance.h"
#include "result_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <type_traits>
#include <utility>

namespace crackle::io {

namespace {

using analysis::ResultInfo;
using analysis::SampleSummary;
using hdf5::Shape;

/// @param version of the file format: results that it lacks remain as in a row without results
std::vector<SampleSummary> read_samples(hid_t file, const Shape& shape, std::int64_t version) {
  const std::size_t n_samples = shape[0];
  const std::size_t n_positions = shape[1] * shape[2];
  const auto status = hdf5::read_dataset<std::int32_t>(file, "samples/status", {n_samples});
  const auto errors = hdf5::read_texts(file, "samples/error");
  const auto wall_time = hdf5::read_dataset<double>(file, "timing/wall_time", {n_samples});
  const auto notes = hdf5::read_texts(file, "samples/note");
  if (errors.size() != n_samples || notes.size() != n_samples)
    throw hdf5::Error("datasets samples/error and note: wrong number of texts");
  // Results missing from an older version stay empty.
  std::vector<SampleSummary> samples(
      n_samples, analysis::empty_summary(static_cast<int>(shape[1]), static_cast<int>(shape[2]),
                                         analysis::SampleStatus::pending));
  for (std::size_t i = 0; i < n_samples; ++i) {
    if (status[i] < 0 || status[i] > 2) fail<hdf5::Error>("sample {}: unknown status", i);
    samples[i].status = static_cast<analysis::SampleStatus>(status[i]);
    samples[i].error = errors[i];
    samples[i].note = notes[i];
    samples[i].wall_time = wall_time[i];
  }
  analysis::for_each_position_result([&](const ResultInfo& info, auto member) {
    if (info.since > version) return;
    using Value = typename std::remove_cvref_t<decltype(std::declval<SampleSummary>().*member)>::value_type;
    const auto table = hdf5::read_dataset<Value>(file, std::string("crack_path/") + info.name, shape);
    for (std::size_t i = 0; i < n_samples; ++i) {
      const auto row = table.begin() + static_cast<std::ptrdiff_t>(i * n_positions);
      (samples[i].*member).assign(row, row + static_cast<std::ptrdiff_t>(n_positions));
    }
  });
  analysis::for_each_result([&](const ResultInfo& info, auto member) {
    if (info.since > version) return;
    using Value = std::remove_cvref_t<decltype(std::declval<SampleSummary>().*member)>;
    const auto column = hdf5::read_dataset<Value>(file, std::string("samples/") + info.name, {n_samples});
    for (std::size_t i = 0; i < n_samples; ++i) samples[i].*member = column[i];
  });
  return samples;
}

/// Reads the values of the random inputs into the rows of finished samples.
/// @return their keys
std::vector<std::string> read_inputs(hid_t file, std::vector<SampleSummary>& samples) {
  std::vector<std::string> found;
  if (H5Lexists(file, "samples/inputs", H5P_DEFAULT) <= 0) return found;
  const hdf5::Handle group = hdf5::open_group(file, "samples/inputs");
  std::istringstream keys(hdf5::read_text_attribute(group, "keys"));
  for (std::string key; std::getline(keys, key);) {
    found.push_back(key);
    const auto column = hdf5::read_dataset<double>(group, key, {samples.size()});
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (samples[i].status != analysis::SampleStatus::pending) samples[i].inputs.push_back(column[i]);
  }
  return found;
}

/// Reads the areas of cracks in the parts of a body of several materials.
void read_parts(hid_t file, std::vector<SampleSummary>& samples) {
  const std::string name = fmt::format("samples/{}", analysis::crack_area_in_info.name);
  if (H5Lexists(file, name.c_str(), H5P_DEFAULT) <= 0) return;
  const Shape shape = hdf5::read_shape(file, name);
  if (shape.size() != 2) fail<hdf5::Error>("dataset {}: not samples x parts", name);
  const auto table = hdf5::read_dataset<double>(file, name, {samples.size(), shape[1]});
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto row = table.begin() + static_cast<std::ptrdiff_t>(i * shape[1]);
    if (samples[i].status == analysis::SampleStatus::done)
      samples[i].crack_area_in.assign(row, row + static_cast<std::ptrdiff_t>(shape[1]));
  }
}

/// Reads the traces of cracks in planes into the rows of completed samples that have them.
void read_traces(hid_t file, std::vector<SampleSummary>& samples) {
  if (H5Lexists(file, "plane_traces", H5P_DEFAULT) <= 0) return;
  const hdf5::Handle group = hdf5::open_group(file, "plane_traces");
  const Shape shape = hdf5::read_shape(group, "length");
  if (shape.size() != 3 || shape[0] != samples.size())
    throw hdf5::Error("dataset plane_traces/length: not samples x planes x cracks");
  const std::size_t n = shape[1] * shape[2];
  analysis::for_each_trace_result([&](const ResultInfo& info, auto member) {
    const auto table = hdf5::read_dataset<double>(group, info.name, shape);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (samples[i].status != analysis::SampleStatus::done) continue;
      samples[i].traces.resize(n);
      for (std::size_t k = 0; k < n; ++k) samples[i].traces[k].*member = table[i * n + k];
    }
  });
  for (SampleSummary& row : samples)
    if (!row.traces.empty() && std::isnan(row.traces.front().length)) row.traces.clear();
}

/// Reads the numbers of the fragments into the rows of completed samples that have them.
void read_fragments(hid_t file, std::vector<SampleSummary>& samples) {
  if (H5Lexists(file, "fragments", H5P_DEFAULT) <= 0) return;
  const hdf5::Handle group = hdf5::open_group(file, "fragments");
  const std::size_t n_shares = analysis::fragment_shares().size();
  const auto heavier = hdf5::read_dataset<double>(group, "heavier", {samples.size(), n_shares});
  const auto is_known = [&](std::size_t i) {
    return samples[i].status == analysis::SampleStatus::done && !std::isnan(heavier[i * n_shares]);
  };
  analysis::for_each_fragment_result([&](const ResultInfo& info, auto member) {
    const auto column = hdf5::read_dataset<double>(group, info.name, {samples.size()});
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (is_known(i)) samples[i].fragments.*member = column[i];
  });
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto first = heavier.begin() + static_cast<std::ptrdiff_t>(i * n_shares);
    if (is_known(i))
      samples[i].fragments.heavier.assign(first, first + static_cast<std::ptrdiff_t>(n_shares));
  }
}

input::Sections read_sections(hid_t file, std::size_t n_sections) {
  const auto position = hdf5::read_dataset<double>(file, "crack_path/section", {n_sections});
  const auto axis = hdf5::read_dataset<std::int32_t>(file, "crack_path/section_axis", {n_sections});
  input::Sections sections;
  for (std::size_t i = 0; i < n_sections; ++i)
    if (axis[i] != 0) (axis[i] == 1 ? sections.y : sections.z).push_back(position[i]);
  const auto n_lines = static_cast<std::size_t>(std::ranges::count(axis, 0));
  if (n_lines == 0) return sections;
  const auto ends = hdf5::read_dataset<double>(file, "crack_path/section_line", {n_lines, 2, 2});
  for (std::size_t i = 0; i < ends.size(); i += 4)
    sections.lines.push_back({{ends[i], ends[i + 1]}, {ends[i + 2], ends[i + 3]}});
  return sections;
}

geometry::MotherPoints read_mother_points(hid_t file) {
  const hdf5::Handle group = hdf5::open_group(file, "mother_points");
  const Shape shape = hdf5::read_shape(group, "spacing");
  if (shape.size() != 1) throw hdf5::Error("dataset mother_points/spacing: wrong number of values");
  geometry::MotherPoints base;
  const auto position = hdf5::read_dataset<double>(group, "position", {shape[0], 3});
  base.position.resize(shape[0]);
  for (std::size_t i = 0; i < position.size(); ++i) base.position[i / 3][i % 3] = position[i];
  base.spacing = hdf5::read_dataset<double>(group, "spacing", shape);
  base.movable = hdf5::read_dataset<std::uint8_t>(group, "movable", shape);
  return base;
}

EnsembleContent read_content(hid_t file, std::int64_t version) {
  const Shape shape = hdf5::read_shape(file, "crack_path/position");
  if (shape.size() != 3) throw hdf5::Error("dataset crack_path/position: not samples x notches x sections");
  EnsembleContent content;
  content.input_text = hdf5::read_text_attribute(file, "input");
  content.sections = read_sections(file, shape[2]);
  content.samples = read_samples(file, shape, version);
  const std::vector<std::string> random_keys = read_inputs(file, content.samples);
  read_parts(file, content.samples);
  read_traces(file, content.samples);
  read_fragments(file, content.samples);
  for (std::size_t i = 0; i < content.samples.size(); ++i) try {
      check_numbers(content.samples[i], random_keys);
    } catch (const hdf5::Error& error) {
      content.samples[i].status = analysis::SampleStatus::pending;
      content.samples[i].error = error.what();
    }
  if (H5Lexists(file, "mother_points", H5P_DEFAULT) > 0) content.base = read_mother_points(file);
  return content;
}

constexpr const char* foreign = "was not written by crackle";

/// True if a file may be the remains of an HDF5 file: empty, zeros, or its first bytes.
bool may_be_hdf5(std::istream& file) {
  constexpr std::array<char, 8> signature{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  std::array<char, 8> start{};
  file.read(start.data(), start.size());
  const auto end = start.begin() + file.gcount();
  return std::equal(start.begin(), end, signature.begin()) ||
         std::all_of(start.begin(), end, [](char c) { return c == 0; });
}

/// The obstacle of a complete HDF5 file: every file of crackle has a text attribute for its kind.
std::string obstacle_of_kind(const hdf5::Handle& root) {
  try {
    if (H5Aexists(root, "kind") <= 0) return foreign;
    const std::string kind = hdf5::read_text_attribute(root, "kind");
    if (kind == ensemble_kind) return {};
    return kind.starts_with("crackle ") ? "is a " + kind + " file" : foreign;
  } catch (const hdf5::Error&) {
    return foreign;
  }
}

template <class Read>
auto read_file(const std::filesystem::path& file, Read&& read) {
  return read_results(file, ensemble_kind, oldest_schema_version, ensemble_schema_version, read);
}

}  // namespace

std::string obstacle(const std::filesystem::path& file) {
  if (const std::string kind = other_kind(file); !kind.empty()) return "is " + kind;
  if (!is_taken(file)) return {};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return fmt::format("cannot be read: {}", std::strerror(errno));
  if (!may_be_hdf5(stream)) return foreign;
  try {
    const hdf5::QuietErrors quiet;
    return obstacle_of_kind(hdf5::open_for_reading(file));
  } catch (const hdf5::Error&) {
    return {};  // truncated or damaged
  }
}

EnsembleContent read_ensemble(const std::filesystem::path& file) {
  return read_file(file, read_content);
}

EnsembleContent read_ensemble(const std::filesystem::path& file, const input::Parameters& parameters) {
  return read_file(file, [&](hid_t id, std::int64_t version) {
    check_input(id, parameters);
    return read_content(id, version);
  });
}

geometry::MotherPoints read_mother_points(const std::filesystem::path& file,
                                          const input::Parameters& parameters) {
  return read_file(file, [&](hid_t id, std::int64_t) {
    check_input(id, parameters);
    return read_mother_points(id);
  });
}

}  // namespace crackle::io
