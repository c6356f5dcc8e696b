// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/result_list.h"
#include "common/checksum.h"
#include "common/failure.h"
#include "common/regular_file.h"
#include "io/ensemble_file.h"
#include "io/sample_file.h"

#include "hdf5.h"
#include "provenance.h"
#include "result_attributes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <system_error>
#include <type_traits>
#include <utility>

namespace crackle::io {

using analysis::SampleSummary;

namespace {

using analysis::ResultInfo;

template <class Read>
auto read_file(const std::filesystem::path& file, std::int64_t oldest, Read&& read) {
  return read_results(file, sample_kind, oldest, sample_schema_version, read);
}

/// The row of a pending sample.
SampleSummary empty_row(const input::Study& study) {
  return analysis::empty_summary(static_cast<int>(geometry::n_crack_starts(study)),
                                 static_cast<int>(study.sections.size()), analysis::SampleStatus::pending);
}

/// Compares the contents of the sample's own raster, as long as it is there, with those that it was made
/// from.
void check_raster(hid_t root, const std::optional<input::MaterialMap>& map, std::uint64_t sample) {
  if (!map || !map->has_file_per_sample() || H5Aexists(root, "map") <= 0) return;
  const auto now = file_digest(map->path(sample));
  if (now && *now != hdf5::read_text_attribute(root, "map"))
    fail<hdf5::Error>("was made from other contents of {}", map->path(sample).string());
}

SampleSummary read_row(hid_t root, std::int64_t version, const input::Parameters& parameters,
                       std::uint64_t sample) {
  const std::int64_t number = hdf5::read_integer_attribute(root, "sample");
  if (number != static_cast<std::int64_t>(sample))
    fail<hdf5::Error>("holds sample {} instead of {}", number, sample);
  // Older versions may have identified inputs differently.
  if (version == sample_schema_version) check_input(root, parameters);
  check_raster(root, parameters.map, sample);
  SampleSummary row = empty_row(parameters);
  const std::int64_t status = hdf5::read_integer_attribute(root, "status");
  if (status != static_cast<std::int64_t>(analysis::SampleStatus::done) &&
      status != static_cast<std::int64_t>(analysis::SampleStatus::failed))
    fail<hdf5::Error>("status {} is neither done (1) nor failed (2)", status);
  row.status = static_cast<analysis::SampleStatus>(status);
  row.error = hdf5::read_text_attribute(root, "error");
  row.note = hdf5::read_text_attribute(root, "note");
  const hdf5::Handle group = hdf5::open_group(root, "summary");
  analysis::for_each_result([&](const ResultInfo& info, auto member) {
    if (info.since > version) return;
    row.*member = hdf5::read_scalar<std::remove_reference_t<decltype(row.*member)>>(group, info.name);
  });
  analysis::for_each_position_result([&](const ResultInfo& info, auto member) {
    if (info.since > version) return;
    using Value = typename std::remove_cvref_t<decltype(row.*member)>::value_type;
    row.*member = hdf5::read_dataset<Value>(group, info.name, position_shape(parameters));
  });
  const char* const parts = analysis::crack_area_in_info.name;
  if (H5Lexists(group, parts, H5P_DEFAULT) > 0)
    row.crack_area_in = hdf5::read_dataset<double>(
        group, parts, {analysis::crack_parts(parameters.materials, parameters.interfaces).size()});
  if (H5Lexists(group, "traces", H5P_DEFAULT) > 0) {
    const hdf5::Handle traces = hdf5::open_group(group, "traces");
    row.traces.resize(parameters.sections.planes.size() *
                      cracks::n_trace_rows(geometry::n_crack_starts(parameters)));
    analysis::for_each_trace_result([&](const ResultInfo& info, auto member) {
      const auto values = hdf5::read_dataset<double>(traces, info.name, {row.traces.size()});
      for (std::size_t k = 0; k < values.size(); ++k) row.traces[k].*member = values[k];
    });
  }
  if (H5Lexists(group, "fragments", H5P_DEFAULT) > 0) {
    const hdf5::Handle fragments = hdf5::open_group(group, "fragments");
    analysis::for_each_fragment_result([&](const ResultInfo& info, auto member) {
      row.fragments.*member = hdf5::read_scalar<double>(fragments, info.name);
    });
    row.fragments.heavier =
        hdf5::read_dataset<double>(fragments, "heavier", {analysis::fragment_shares().size()});
  }
  if (!parameters.random.empty()) {
    const hdf5::Handle inputs = hdf5::open_group(group, "inputs");
    for (const input::RandomInput& random : parameters.random)
      row.inputs.push_back(hdf5::read_scalar<double>(inputs, random.key));
  }
  row.wall_time = hdf5::read_scalar<double>(root, "timing/wall_time");
  check_numbers(row, random_keys(parameters.random));
  return row;
}

std::int64_t model_of(hid_t root) {
  return H5Aexists(root, "model_version") > 0 ? hdf5::read_integer_attribute(root, "model_version") : 1;
}

/// @throws OlderFormat when the sample is of another model
void require_model(hid_t root) {
  const std::int64_t model = model_of(root);
  if (model == model_version) return;
  fail<OlderFormat>("model {}, of version {} of the program; the results of this program's model {} differ",
                    model, hdf5::read_text_attribute(root, "program_version"), model_version);
}

/// The sample files of a folder, by number.
std::vector<std::filesystem::path> sample_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "samples", ignored))
    if (entry.path().extension() == ".h5") files.push_back(entry.path());
  // Numbers above 9999 have more digits.
  std::ranges::sort(files, {}, [](const std::filesystem::path& file) {
    return std::pair(file.native().size(), file.native());
  });
  return files;
}

/// Reads one column of a table into a member of its rows.
template <class Value, class Row, class Member>
void read_column(hid_t group, const std::string& name, std::vector<Row>& rows, Member Row::*member) {
  const auto values = hdf5::read_dataset<Value>(group, name, {rows.size()});
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].*member = static_cast<Member>(values[i]);
}

cracks::CrackSurface read_surface(hid_t root) {
  using cracks::Crack;
  using cracks::CrackFacet;
  const hdf5::Handle group = hdf5::open_group(root, "crack_surface");
  cracks::CrackSurface surface;
  auto& [facets, cracks, entries] = surface;
  cracks.resize(hdf5::read_shape(group, "cracks/notch").at(0));
  read_column<std::int32_t>(group, "cracks/notch", cracks, &Crack::start);
  if (H5Lexists(group, "cracks/hole", H5P_DEFAULT) > 0)  // not in older files
    read_column<std::int32_t>(group, "cracks/hole", cracks, &Crack::hole);
  read_column<double>(group, "cracks/area", cracks, &Crack::area);
  read_column<double>(group, "cracks/first_time", cracks, &Crack::first_time);
  read_column<double>(group, "cracks/last_time", cracks, &Crack::last_time);
  facets.resize(hdf5::read_shape(group, "crack").at(0));
  const auto corners = hdf5::read_dataset<double>(group, "corners", {facets.size(), 4, 3});
  for (std::size_t k = 0; k < corners.size(); ++k) facets[k / 12].corner[k / 3 % 4][k % 3] = corners[k];
  read_column<double>(group, "time", facets, &CrackFacet::time);
  read_column<double>(group, "area", facets, &CrackFacet::area);
  read_column<std::int64_t>(group, "tetrahedron", facets, &CrackFacet::tetrahedron);
  read_column<std::int32_t>(group, "crack", facets, &CrackFacet::crack);
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (facets[i].crack < 0 || static_cast<std::size_t>(facets[i].crack) >= cracks.size())
      fail<hdf5::Error>("facet {} belongs to crack {}, but there are only {} cracks", i, facets[i].crack,
                        cracks.size());
    const auto values = std::span(corners).subspan(12 * i, 12);
    if (!std::ranges::all_of(values, [](double x) { return std::isfinite(x); }) ||
        !std::isfinite(facets[i].time) || !std::isfinite(facets[i].area))
      fail<hdf5::Error>("the corners, time or area of facet {} of its crack are not numbers", i);
  }
  return surface;
}

std::vector<cracks::BranchingPoint> read_branching(hid_t root) {
  using cracks::BranchingPoint;
  const hdf5::Handle group = hdf5::open_group(root, "forks");
  std::vector<BranchingPoint> points(hdf5::read_shape(group, "x").at(0));
  const auto position = hdf5::read_dataset<double>(group, "position", {points.size(), 2});
  for (std::size_t k = 0; k < position.size(); ++k)
    (k % 2 == 0 ? points[k / 2].y : points[k / 2].z) = position[k];
  read_column<double>(group, "x", points, &BranchingPoint::x);
  read_column<double>(group, "time", points, &BranchingPoint::time);
  read_column<double>(group, "length", points, &BranchingPoint::length);
  read_column<double>(group, "angle", points, &BranchingPoint::angle);
  read_column<double>(group, "share", points, &BranchingPoint::share);
  read_column<std::int32_t>(group, "notch", points, &BranchingPoint::start);
  read_column<std::uint8_t>(group, "in_projection", points, &BranchingPoint::is_in_projection);
  read_column<std::uint8_t>(group, "in_space", points, &BranchingPoint::is_in_space);
  return points;
}

/// Format version of a complete file; empty if it is unusable.
std::optional<std::int64_t> version_of(const std::filesystem::path& file, const char* kind,
                                       std::int64_t newest) {
  try {
    return read_results(file, kind, 0, newest, [](hid_t, std::int64_t version) { return version; });
  } catch (const std::exception&) {
    return std::nullopt;  // reading its results reports the error
  }
}

}  // namespace

SampleSummary read_summary(const std::filesystem::path& file, const input::Parameters& parameters,
                           std::uint64_t sample) {
  return read_file(file, sample_schema_version, [&](hid_t root, std::int64_t version) {
    require_model(root);
    return read_row(root, version, parameters, sample);
  });
}

std::string read_input_text(const std::filesystem::path& file) {
  return read_file(file, oldest_schema_version,
                   [](hid_t root, std::int64_t) { return hdf5::read_text_attribute(root, "input"); });
}

std::int64_t format_version(const std::filesystem::path& folder) {
  const std::int64_t oldest = version_of(folder / "ensemble.h5", ensemble_kind, ensemble_schema_version)
                                  .value_or(sample_schema_version);
  // Runs never continue with files of an older version, so checking one file is enough.
  for (const auto& file : sample_files(folder))
    if (const auto version = version_of(file, sample_kind, sample_schema_version))
      return std::min(oldest, *version);
  return oldest;
}

std::int64_t stored_model(const std::filesystem::path& folder) {
  for (const auto& file : sample_files(folder)) {
    try {
      return read_file(file, oldest_schema_version, [](hid_t root, std::int64_t) { return model_of(root); });
    } catch (const std::exception&) {
      // Reading its results reports the error.
    }
  }
  return holds_older_format(folder) ? 0 : model_version;
}

void check_model(const std::filesystem::path& folder) {
  for (const auto& file : sample_files(folder)) {
    try {
      return read_file(file, sample_schema_version, [](hid_t root, std::int64_t) { require_model(root); });
    } catch (const OlderFormat&) {
      throw;
    } catch (const std::exception&) {
      // Reading its results reports the error.
    }
  }
}

SampleReader::SampleReader(std::filesystem::path folder, const input::Parameters& parameters)
    : folder_(std::move(folder)), parameters_(&parameters), model_(stored_model(folder_)) {}

/// `read(root, version)` of the sample's file.
template <class Read>
SampleSummary SampleReader::row_or_reason(std::uint64_t sample, const Read& read) const {
  const std::filesystem::path file = sample_path(folder_, sample);
  try {
    if (!is_taken(file)) return empty_row(*parameters_);
    return read_file(file, oldest_schema_version, [&](hid_t root, std::int64_t version) {
      if (const std::int64_t model = model_of(root); model != model_)
        fail<hdf5::Error>("model {}, of version {} of the program; the other samples are of model {}", model,
                          hdf5::read_text_attribute(root, "program_version"), model_);
      return read(root, version);
    });
  } catch (const std::exception& error) {
    SampleSummary row = empty_row(*parameters_);
    row.error = error.what();
    return row;
  }
}

SampleSummary SampleReader::row(std::uint64_t sample) const {
  return row_or_reason(sample, [&](hid_t root, std::int64_t version) {
    return read_row(root, version, *parameters_, sample);
  });
}

StoredSample SampleReader::whole(std::uint64_t sample) const {
  StoredSample stored;
  stored.summary = row_or_reason(sample, [&](hid_t root, std::int64_t version) {
    SampleSummary row = read_row(root, version, *parameters_, sample);
    if (row.status == analysis::SampleStatus::done) {
      stored.surface = read_surface(root);
      stored.branching = read_branching(root);
    }
    return row;
  });
  return stored;
}

std::vector<SampleSummary> read_summaries(const std::filesystem::path& folder,
                                          const input::Parameters& parameters, std::uint64_t first,
                                          std::size_t count) {
  const SampleReader reader(folder, parameters);
  std::vector<SampleSummary> rows;
  for (std::uint64_t sample = first; sample < first + count; ++sample) rows.push_back(reader.row(sample));
  return rows;
}

}  // namespace crackle::io
