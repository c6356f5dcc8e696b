// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "hdf5.h"
#include "input/parameters.h"
#include "io/sample_file.h"
#include "partial_file.h"

#include <filesystem>
#include <stdexcept>
#include <string>

namespace crackle::io {

inline constexpr const char* sample_kind = "crackle sample";
inline constexpr const char* ensemble_kind = "crackle ensemble";

/// Shape of results at the sections: crack starts x sections.
inline hdf5::Shape position_shape(const input::Study& study) {
  return {geometry::n_crack_starts(study), study.sections.size()};
}

/// Writes the root attributes of every result file: kind, schema_version, program_version, git_commit,
/// library_versions, seed, input, points (the digest of mesh.points), solid (of specimen.solid, if given),
/// input_identity, engine, same_bits (input::same_bits).
void write_identity(hid_t file, const std::string& kind, std::int64_t schema_version,
                    const input::Parameters& parameters);

/// @return the version of its format
/// @throws OlderFormat when it is below `oldest`
/// @throws hdf5::Error when the file is of another kind, or of a version above `newest`
std::int64_t check_identity(hid_t file, const std::string& kind, std::int64_t oldest, std::int64_t newest);

/// @throws hdf5::Error unless the file was made from an input with the same samples (input::sample_identity)
///   and the same contents of mesh.points and specimen.solid
void check_input(hid_t file, const input::Parameters& parameters);

/// Calls `read(root, version)` for a complete result file.
/// @throws OlderFormat, std::runtime_error prefixed with the file's name
template <class Read>
auto read_results(const std::filesystem::path& file, const char* kind, std::int64_t oldest,
                  std::int64_t newest, Read&& read) {
  const auto cannot_use = [&](const std::exception& error) {
    return "cannot use '" + file.string() + "': " + error.what();
  };
  try {
    // HDF5 can crash on a damaged file, so check it first.
    if (kind == sample_kind) read_checked_file(file);
    const hdf5::QuietErrors quiet;
    const hdf5::Handle root = hdf5::open_for_reading(file);
    return read(root, check_identity(root, kind, oldest, newest));
  } catch (const OlderFormat& error) {
    throw OlderFormat(cannot_use(error));
  } catch (const std::exception& error) {
    throw std::runtime_error(cannot_use(error));
  }
}

/// Writes the group /provenance: where and when the file was written, by how many ranks.
void write_provenance(hid_t file, int n_ranks);

}  // namespace crackle::io
