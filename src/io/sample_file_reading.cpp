// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/sample_file.h"

#include "checked_file.h"
#include "hdf5.h"
#include "provenance.h"
#include "sample_shape.h"
#include "summary_columns.h"

#include <fmt/format.h>

#include <stdexcept>
#include <type_traits>

namespace crackle::io {

using analysis::SampleSummary;

SampleSummary read_summary(const std::filesystem::path& file, const input::Parameters& parameters,
                           std::uint64_t sample) {
  try {
    // HDF5 must not see a damaged file: it can crash on one.
    read_checked_file(file);
    const hdf5::QuietErrors quiet;
    const hdf5::Handle root = hdf5::open_for_reading(file);
    check_identity(root.get(), sample_kind, sample_schema_version);
    const std::int64_t number = hdf5::read_integer_attribute(root.get(), "sample");
    if (number != static_cast<std::int64_t>(sample)) {
      throw hdf5::Error(fmt::format("holds sample {} instead of {}", number, sample));
    }
    check_input(root.get(), parameters);
    SampleSummary row;
    const std::int64_t status = hdf5::read_integer_attribute(root.get(), "status");
    if (status != static_cast<std::int64_t>(analysis::SampleStatus::done) &&
        status != static_cast<std::int64_t>(analysis::SampleStatus::failed)) {
      throw hdf5::Error(fmt::format("status {} is neither done (1) nor failed (2)", status));
    }
    row.status = static_cast<analysis::SampleStatus>(status);
    row.error = hdf5::read_text_attribute(root.get(), "error");
    const hdf5::Handle group = hdf5::open_group(root.get(), "summary");
    const hid_t id = group.get();
    for_each_result([&](const char* name, auto member, const char*) {
      row.*member = hdf5::read_scalar<std::remove_reference_t<decltype(row.*member)>>(id, name);
    });
    for_each_position_result([&](const char* name, auto member, const char*) {
      using Value = typename std::remove_cvref_t<decltype(row.*member)>::value_type;
      row.*member = hdf5::read_dataset<Value>(id, name, position_shape(parameters));
    });
    const hdf5::Handle timing = hdf5::open_group(root.get(), "timing");
    row.wall_time = hdf5::read_scalar<double>(timing.get(), "wall_time");
    return row;
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot use '" + file.string() + "': " + error.what());
  }
}

std::vector<SampleSummary> read_summaries(const std::filesystem::path& folder,
                                          const input::Parameters& parameters, std::uint64_t first,
                                          std::size_t count) {
  const auto n_notches = static_cast<int>(parameters.specimen.notches.size());
  const auto n_sections = static_cast<int>(parameters.sections.y.size());
  std::vector<SampleSummary> rows;
  for (std::size_t i = 0; i < count; ++i) {
    rows.push_back(analysis::empty_summary(n_notches, n_sections, analysis::SampleStatus::pending));
    const std::filesystem::path file = sample_path(folder, first + i);
    try {
      if (std::filesystem::exists(file)) rows.back() = read_summary(file, parameters, first + i);
    } catch (const std::exception& error) {
      rows.back().error = error.what();
    }
  }
  return rows;
}

}  // namespace crackle::io
