// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands.h"
#include "common/failure.h"
#include "common/packing.h"
#include "common/printable.h"
#include "common/quantity_text.h"
#include "common/regular_file.h"
#include "common/whole_number.h"
#include "geometry/mesh_statistics.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "solid/solid.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdio>
#include <sstream>
#include <utility>

namespace crackle::apps {

CLI::Option* add_sample_option(CLI::App& command, std::uint64_t& sample) {
  return command.add_option("--sample", sample, "number of the sample, from 0")
      ->check([](const std::string& text) {
        return whole_number<std::uint64_t>(text)
                   ? std::string()
                   : "'" + text + "' is not a sample number; give a whole number from 0 on";
      });
}

void refuse_existing(const std::filesystem::path& file) {
  if (is_taken(file)) fail("{} already exists; give another name", file.string());
}

void notify(const std::string& line) {
  fmt::print(stderr, "{}\n", printable(line));
}

namespace {

/// The content of a solid's file and what it was read with; empty without a solid.
std::vector<std::byte> packed_solid(const std::shared_ptr<const solid::Solid>& solid) {
  Packer packer;
  if (!solid) return packer.bytes();
  packer.put(solid->content);
  packer.put(solid->extension);
  packer.put(solid->unit);
  packer.put(solid->metres);
  return packer.bytes();
}

std::shared_ptr<const solid::Solid> unpacked_solid(const std::vector<std::byte>& packed) {
  if (packed.empty()) return nullptr;
  Unpacker unpacker(packed);
  auto content = unpacker.get<std::string>();
  const auto extension = unpacker.get<std::string>(), unit = unpacker.get<std::string>();
  const auto metres = unpacker.get<double>();
  return std::make_shared<const solid::Solid>(solid::read_solid(std::move(content), extension, unit, metres));
}

}  // namespace

input::Parameters share_input(const parallel::Communicator& world, const std::filesystem::path& name,
                              const std::function<input::Parameters()>& read) {
  input::Parameters parameters;
  parallel::agree_on_root(world, [&] { parameters = read(); });
  const bool is_root = world.is_root();
  const bool has_points = is_root && parameters.mesh.points;
  const std::string text = parallel::share(world, parameters.text);
  input::GivenFiles files;
  files.points = parallel::share(world, has_points ? parameters.mesh.points->string() : std::string());
  files.points_digest = parallel::share(world, parameters.mesh.points_digest);
  const auto packed = parallel::share(world, packed_solid(parameters.specimen.solid));
  return parallel::agree(world, [&] {
    if (is_root) return std::move(parameters);
    files.known_solid = unpacked_solid(packed);
    return input::parse(text, name, files);
  });
}

namespace {

/// Calls `read()`; an InputError becomes the same AgreedError on every rank.
template <class Read>
auto with_input_errors(Read&& read) {
  try {
    return read();
  } catch (const parallel::AgreedError& error) {
    std::vector<std::string> messages;
    std::istringstream lines(error.what());
    for (std::string line; std::getline(lines, line);) messages.push_back(line);
    throw input::InputError(messages);
  }
}

}  // namespace

input::Parameters read_input(const parallel::Communicator& world, const std::filesystem::path& file,
                             const input::GivenFiles& files) {
  return with_input_errors(
      [&] { return share_input(world, file, [&] { return input::read(file, files); }); });
}

input::Parameters read_given_input(const parallel::Communicator& world, const std::filesystem::path& file) {
  input::Parameters parameters = read_input(world, file);
  if (world.is_root())
    for (const std::string& note : parameters.notes) notify(note);
  return parameters;
}

std::vector<input::Case> read_cases(const parallel::Communicator& world, const input::Parameters& parameters,
                                    const std::filesystem::path& file, bool are_stored) {
  return with_input_errors([&] {
    return parallel::agree(world, [&] { return input::sweep_cases(parameters, file, are_stored); });
  });
}

void refuse_sweep(const input::Parameters& parameters, const std::filesystem::path& file) {
  if (parameters.sweeps.empty()) return;
  throw input::InputError({fmt::format(
      "{}: this is a sweep of several inputs; crackle run computes all of them, and leaves the input of each "
      "in its folder",
      file.string())});
}

input::Parameters read_sections(const parallel::Communicator& world, const input::Parameters& parameters,
                                const std::vector<std::string>& given) {
  return with_input_errors([&] {
    return parallel::agree(world, [&] { return input::with_sections(parameters, given, "--sections"); });
  });
}

std::vector<NamedValue> face_rows(const plane::Specimen& specimen) {
  std::vector<NamedValue> rows;
  if (!specimen.solid) return rows;
  // Rounding errors are not shown as such.
  const auto shown = [](const Vector& values, double factor) {
    std::array<double, 3> rounded{};
    for (std::size_t i = 0; i < 3; ++i) rounded[i] = std::round(values[i] * factor * 1e3) / 1e3 + 0.0;
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", rounded[0], rounded[1], rounded[2]);
  };
  for (const solid::NamedFace& face : solid::named_faces(*specimen.solid))
    rows.emplace_back(
        face.name,
        fmt::format("{}, {:.5g} mm^2 about {} mm{}", count_text(face.n_planes, "plane"), 1e6 * face.area,
                    shown(face.centre, 1e3),
                    norm(face.outward) < 1e-3
                        ? ", closed"
                        : fmt::format(", normal {}", shown(face.outward / norm(face.outward), 1))));
  if (const double moved = specimen.solid->moved; moved > 0)
    rows.emplace_back("flattened", fmt::format("points are moved by up to {} onto the planes of faces",
                                               quantity_text(moved, "m")));
  return rows;
}

std::vector<NamedValue> material_rows(const input::Parameters& parameters,
                                      const geometry::Realization& realization) {
  std::vector<NamedValue> rows;
  const auto contents = geometry::material_contents(realization);
  for (std::size_t i = 0; i < contents.size(); ++i)
    rows.emplace_back(
        fmt::format("material {}", parameters.materials[i].name),
        fmt::format("{} tetrahedra, {:.6g} mm^3", contents[i].tetrahedra, 1e9 * contents[i].volume));
  return rows;
}

}  // namespace crackle::apps
