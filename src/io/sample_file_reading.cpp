// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/sample_file.h"

#include "checked_file.h"
#include "crackle/analysis/sample_results.h"
#include "crackle/io/ensemble_file.h"
#include "hdf5.h"
#include "provenance.h"
#include "sample_shape.h"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <system_error>
#include <type_traits>

namespace crackle::io {

using analysis::SampleSummary;

namespace {

using analysis::ResultInfo;

/// `read(root, version)` of a whole sample file. @throws with the file's name in front
template <class Read>
auto read_file(const std::filesystem::path& file, std::int64_t oldest, Read&& read) {
  const auto cannot_use = [&](const std::exception& error) {
    return "cannot use '" + file.string() + "': " + error.what();
  };
  try {
    // HDF5 must not see a damaged file: it can crash on one.
    read_checked_file(file);
    const hdf5::QuietErrors quiet;
    const hdf5::Handle root = hdf5::open_for_reading(file);
    return read(root.get(), check_identity(root.get(), sample_kind, oldest, sample_schema_version));
  } catch (const OlderFormat& error) {
    throw OlderFormat(cannot_use(error));
  } catch (const std::exception& error) {
    throw std::runtime_error(cannot_use(error));
  }
}

SampleSummary read_row(hid_t root, std::int64_t version, const input::Parameters& parameters,
                       std::uint64_t sample) {
  const std::int64_t number = hdf5::read_integer_attribute(root, "sample");
  if (number != static_cast<std::int64_t>(sample)) {
    throw hdf5::Error(fmt::format("holds sample {} instead of {}", number, sample));
  }
  // How an input is told from another one may have changed since an older version.
  if (version == sample_schema_version) check_input(root, parameters);
  SampleSummary row;
  const std::int64_t status = hdf5::read_integer_attribute(root, "status");
  if (status != static_cast<std::int64_t>(analysis::SampleStatus::done) &&
      status != static_cast<std::int64_t>(analysis::SampleStatus::failed)) {
    throw hdf5::Error(fmt::format("status {} is neither done (1) nor failed (2)", status));
  }
  row.status = static_cast<analysis::SampleStatus>(status);
  row.error = hdf5::read_text_attribute(root, "error");
  if (version >= 3) row.note = hdf5::read_text_attribute(root, "note");
  const hdf5::Handle group = hdf5::open_group(root, "summary");
  const hid_t id = group.get();
  analysis::for_each_result([&](const ResultInfo& info, auto member) {
    if (info.since > version) return;
    row.*member =
        hdf5::read_scalar<std::remove_reference_t<decltype(row.*member)>>(id, info.name_in(version));
  });
  analysis::for_each_position_result([&](const ResultInfo& info, auto member) {
    if (info.since > version) return;
    using Value = typename std::remove_cvref_t<decltype(row.*member)>::value_type;
    row.*member = hdf5::read_dataset<Value>(id, info.name_in(version), position_shape(parameters));
  });
  const hdf5::Handle timing = hdf5::open_group(root, "timing");
  row.wall_time = hdf5::read_scalar<double>(timing.get(), "wall_time");
  return row;
}

/// `read(file)`; where there is no such file a pending row, and where it cannot be used one with the reason.
template <class Read>
SampleSummary row_or_reason(const std::filesystem::path& file, const input::Parameters& parameters,
                            Read&& read) {
  SampleSummary row =
      analysis::empty_summary(static_cast<int>(geometry::n_crack_starts(parameters.specimen)),
                              static_cast<int>(parameters.sections.size()), analysis::SampleStatus::pending);
  try {
    if (std::filesystem::exists(file)) row = read(file);
  } catch (const std::exception& error) {
    row.error = error.what();
  }
  return row;
}

analysis::CrackSurface read_surface(hid_t root) {
  const hdf5::Handle group = hdf5::open_group(root, "crack_surface");
  const hid_t id = group.get();
  const auto n_facets = hdf5::read_shape(id, "crack").at(0);
  const auto corners = hdf5::read_dataset<double>(id, "corners", {n_facets, 4, 3});
  const auto time = hdf5::read_dataset<double>(id, "time", {n_facets});
  const auto area = hdf5::read_dataset<double>(id, "area", {n_facets});
  const auto tetrahedron = hdf5::read_dataset<std::int64_t>(id, "tetrahedron", {n_facets});
  const auto crack = hdf5::read_dataset<std::int32_t>(id, "crack", {n_facets});
  const auto n_cracks = hdf5::read_shape(id, "cracks/notch").at(0);
  const auto notch = hdf5::read_dataset<std::int32_t>(id, "cracks/notch", {n_cracks});
  const auto crack_area = hdf5::read_dataset<double>(id, "cracks/area", {n_cracks});
  const auto first_time = hdf5::read_dataset<double>(id, "cracks/first_time", {n_cracks});
  const auto last_time = hdf5::read_dataset<double>(id, "cracks/last_time", {n_cracks});

  analysis::CrackSurface surface;
  for (std::size_t i = 0; i < n_cracks; ++i)
    surface.cracks.push_back({notch[i], crack_area[i], first_time[i], last_time[i]});
  surface.facets.resize(n_facets);
  for (std::size_t i = 0; i < n_facets; ++i) {
    analysis::CrackFacet& facet = surface.facets[i];
    if (crack[i] < 0 || static_cast<std::size_t>(crack[i]) >= n_cracks)
      throw hdf5::Error(fmt::format("facet {} is of crack {}, and there are {}", i, crack[i], n_cracks));
    for (std::size_t k = 0; k < 12; ++k) facet.corner[k / 3][k % 3] = corners[12 * i + k];
    facet.time = time[i];
    facet.area = area[i];
    facet.tetrahedron = tetrahedron[i];
    facet.crack = crack[i];
  }
  return surface;
}

std::vector<analysis::Fork> read_forks(hid_t root) {
  const hdf5::Handle group = hdf5::open_group(root, "forks");
  const hid_t id = group.get();
  const auto n = hdf5::read_shape(id, "x").at(0);
  const auto position = hdf5::read_dataset<double>(id, "position", {n, 2});
  const auto x = hdf5::read_dataset<double>(id, "x", {n});
  const auto time = hdf5::read_dataset<double>(id, "time", {n});
  const auto length = hdf5::read_dataset<double>(id, "length", {n});
  const auto angle = hdf5::read_dataset<double>(id, "angle", {n});
  const auto share = hdf5::read_dataset<double>(id, "share", {n});
  const auto notch = hdf5::read_dataset<std::int32_t>(id, "notch", {n});
  const auto in_projection = hdf5::read_dataset<std::uint8_t>(id, "in_projection", {n});
  const auto in_space = hdf5::read_dataset<std::uint8_t>(id, "in_space", {n});
  std::vector<analysis::Fork> forks;
  for (std::size_t i = 0; i < n; ++i)
    forks.push_back({notch[i], x[i], position[2 * i], position[2 * i + 1], time[i], length[i], angle[i],
                     share[i], in_projection[i] != 0, in_space[i] != 0});
  return forks;
}

/// Version of a whole file's format; nothing when it cannot be used.
std::optional<std::int64_t> version_of(const std::filesystem::path& file, const char* kind,
                                       std::int64_t newest) {
  try {
    if (kind == sample_kind) read_checked_file(file);
    const hdf5::QuietErrors quiet;
    const hdf5::Handle root = hdf5::open_for_reading(file);
    return check_identity(root.get(), kind, 0, newest);
  } catch (const std::exception&) {
    return std::nullopt;  // whoever reads its results says what is wrong with it
  }
}

}  // namespace

SampleSummary read_summary(const std::filesystem::path& file, const input::Parameters& parameters,
                           std::uint64_t sample) {
  return read_file(file, sample_schema_version, [&](hid_t root, std::int64_t version) {
    return read_row(root, version, parameters, sample);
  });
}

SampleSummary read_any_summary(const std::filesystem::path& file, const input::Parameters& parameters,
                               std::uint64_t sample) {
  return read_file(file, oldest_schema_version, [&](hid_t root, std::int64_t version) {
    return read_row(root, version, parameters, sample);
  });
}

std::string read_input_text(const std::filesystem::path& file) {
  return read_file(file, oldest_schema_version,
                   [](hid_t root, std::int64_t) { return hdf5::read_text_attribute(root, "input"); });
}

bool holds_older_format(const std::filesystem::path& folder) {
  std::error_code ignored;
  const auto of_ensemble = version_of(folder / "ensemble.h5", ensemble_kind, ensemble_schema_version);
  if (of_ensemble && *of_ensemble < ensemble_schema_version) return true;
  // No run goes on with files of an older version, so one file stands for all.
  for (const auto& entry : std::filesystem::directory_iterator(folder / "samples", ignored)) {
    if (entry.path().extension() != ".h5") continue;
    if (const auto version = version_of(entry.path(), sample_kind, sample_schema_version))
      return *version < sample_schema_version;
  }
  return false;
}

std::vector<SampleSummary> read_summaries(const std::filesystem::path& folder,
                                          const input::Parameters& parameters, std::uint64_t first,
                                          std::size_t count) {
  std::vector<SampleSummary> rows;
  for (std::uint64_t sample = first; sample < first + count; ++sample) {
    rows.push_back(row_or_reason(sample_path(folder, sample), parameters, [&](const auto& file) {
      return read_any_summary(file, parameters, sample);
    }));
  }
  return rows;
}

StoredSample read_stored_sample(const std::filesystem::path& folder, const input::Parameters& parameters,
                                std::uint64_t sample) {
  StoredSample stored;
  stored.summary = row_or_reason(sample_path(folder, sample), parameters, [&](const auto& path) {
    return read_file(path, oldest_schema_version, [&](hid_t root, std::int64_t version) {
      SampleSummary row = read_row(root, version, parameters, sample);
      if (row.status == analysis::SampleStatus::done) stored.surface = read_surface(root);
      if (row.status == analysis::SampleStatus::done && version >= 3) stored.forks = read_forks(root);
      return row;
    });
  });
  return stored;
}

}  // namespace crackle::io
