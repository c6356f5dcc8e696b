// SPDX-License-Identifier: GPL-3.0-or-later
#include "provenance.h"

#include "common/failure.h"
#include "input/reader.h"
#include "version.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <ctime>

namespace crackle::io {

namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

}  // namespace

void write_identity(hid_t file, const std::string& kind, std::int64_t schema_version,
                    const input::Parameters& parameters) {
  hdf5::write_attribute(file, "kind", kind);
  hdf5::write_attribute(file, "schema_version", schema_version);
  hdf5::write_attribute(file, "program_version", program_version());
  hdf5::write_attribute(file, "git_commit", git_commit());
  hdf5::write_attribute(file, "library_versions", library_versions());
  hdf5::write_attribute(file, "seed", parameters.seed);
  hdf5::write_attribute(file, "input", parameters.text);
  hdf5::write_attribute(file, "points", parameters.mesh.points_digest);
  if (parameters.specimen.solid) hdf5::write_attribute(file, "solid", parameters.specimen.solid->digest);
  hdf5::write_attribute(file, "input_identity", input::sample_identity(parameters));
  hdf5::write_attribute(file, "engine", std::string(input::to_string(parameters.time.engine)));
  hdf5::write_attribute(file, "same_bits", input::same_bits(parameters.time.engine));
}

std::int64_t check_identity(hid_t file, const std::string& kind, std::int64_t oldest, std::int64_t newest) {
  if (H5Aexists(file, "kind") <= 0 || hdf5::read_text_attribute(file, "kind") != kind) {
    throw hdf5::Error("not a " + kind + " file");
  }
  const std::int64_t version = hdf5::read_integer_attribute(file, "schema_version");
  if (version > newest)
    fail<hdf5::Error>("version {} of the file format; this program reads versions up to {}", version, newest);
  if (version < oldest)
    fail<OlderFormat>(
        "version {} of the file format, written by version {} of the program; this program "
        "writes version {}",
        version, hdf5::read_text_attribute(file, "program_version"), newest);
  return version;
}

void check_input(hid_t file, const input::Parameters& parameters) {
  if (hdf5::read_text_attribute(file, "input_identity") != input::sample_identity(parameters)) {
    throw hdf5::Error("was made from another input");
  }
  const auto check_digest = [&](const char* name, const char* what, const std::string& wanted) {
    const std::string found =
        H5Aexists(file, name) > 0 ? hdf5::read_text_attribute(file, name) : std::string();
    if (found != wanted)
      fail<hdf5::Error>("was made from {} ({}, not {})", what, found.empty() ? "none" : found, wanted);
  };
  check_digest("points", "other points", parameters.mesh.points_digest);
  check_digest("solid", "another solid", solid::digest_of(parameters.specimen.solid));
}

void write_provenance(hid_t file, int n_ranks) {
  const hdf5::Handle group = hdf5::create_group(file, "provenance");
  hdf5::write_attribute(group, "host", host_name());
  hdf5::write_attribute(group, "written",
                        fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))));
  hdf5::write_attribute(group, "ranks", std::int64_t{n_ranks});
}

}  // namespace crackle::io
