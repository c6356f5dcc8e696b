// SPDX-License-Identifier: GPL-3.0-or-later
// Prints the stress of every tetrahedron at every frame of the file of sample 1, as computed by the program:
// frames x tetrahedra x 6 numbers in native doubles.
#include "fracture/breakable_body.h"
#include "fracture/initial_strain.h"
#include "fracture/material_field.h"
#include "fracture/release_time.h"
#include "input/reader.h"

#include "io/hdf5.h"
#include "support/box_mesh.h"

#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

namespace crackle {
namespace {

namespace hdf5 = io::hdf5;

constexpr double infinity = std::numeric_limits<double>::infinity();

template <class Value>
std::vector<Value> read(hid_t file, const std::string& name) {
  return hdf5::read_dataset<Value>(file, name, hdf5::read_shape(file, name));
}

/// A file and its data on one sample.
struct Sample {
  explicit Sample(hid_t file)
      : parameters(input::parse(hdf5::read_text_attribute(file, "input"), "input")),
        phase_start(read<double>(file, "summary/phase_start").front()),
        time(read<double>(file, "frames/time")),
        displacement(read<float>(file, "frames/displacement")) {
    const auto nodes = read<double>(file, "mesh/nodes");
    for (std::size_t i = 0; i < nodes.size(); i += 3)
      mesh.nodes.push_back({nodes[i], nodes[i + 1], nodes[i + 2]});
    const auto corners = read<std::int32_t>(file, "mesh/tetrahedra");
    for (std::size_t i = 0; i < corners.size(); i += 4)
      mesh.tetrahedra.push_back({corners[i], corners[i + 1], corners[i + 2], corners[i + 3]});
    if (H5Lexists(file, "mesh/material", H5P_DEFAULT) > 0)
      mesh.material = read<std::uint8_t>(file, "mesh/material");
    const auto broken = read<std::int64_t>(file, "breaks/tetrahedron");
    const auto load_time = read<double>(file, "breaks/load_time");
    const auto phase_time = read<double>(file, "breaks/phase_time");
    const auto cut = read<std::int32_t>(file, "breaks/cut");
    for (std::size_t i = 0; i < broken.size(); ++i)
      breaks.push_back({broken[i], load_time[i], phase_time[i], 0, 0, cut[i]});
    if (parameters.fracture.softens()) {
      const auto softened = read<std::int64_t>(file, "softening/tetrahedron");
      const auto fall_load_time = read<double>(file, "softening/load_time");
      const auto fall_phase_time = read<double>(file, "softening/phase_time");
      const auto share = read<double>(file, "softening/share");
      for (std::size_t i = 0; i < softened.size(); ++i)
        stiffness_reductions.push_back({softened[i], fall_load_time[i], fall_phase_time[i], 0, share[i], 0});
    }
    if (parameters.fracture.release != input::Release::facet) return;
    const auto tied = read<std::int64_t>(file, "bridge_releases/tetrahedron");
    const auto tie_load_time = read<double>(file, "bridge_releases/load_time");
    const auto tie_phase_time = read<double>(file, "bridge_releases/phase_time");
    const auto edges = read<std::uint8_t>(file, "bridge_releases/edges");
    for (std::size_t i = 0; i < tied.size(); ++i)
      bridge_releases.push_back({tied[i], tie_load_time[i], tie_phase_time[i], 0, edges[i]});
  }

  input::Parameters parameters;
  double phase_start;
  geometry::Realization mesh;
  std::vector<fracture::Break> breaks;
  std::vector<fracture::BridgeRelease> bridge_releases;
  std::vector<fracture::StiffnessReduction> stiffness_reductions;
  std::vector<double> time;
  std::vector<float> displacement;
};

void print_stresses(const std::filesystem::path& path) {
  const hdf5::Handle file = hdf5::open_for_reading(path);
  const Sample sample(file);
  const geometry::Subdomain subdomain = test::whole(sample.mesh);
  const std::size_t n_values = 3 * sample.mesh.nodes.size();
  for (std::size_t k = 0; k < sample.time.size(); ++k) {
    const auto is_open = [&](const auto& record) {
      return std::pair(record.load_time, record.phase_time) <= std::pair(sample.phase_start, sample.time[k]);
    };
    fracture::Releases releases;
    std::ranges::copy_if(sample.breaks, std::back_inserter(releases.breaks), is_open);
    std::ranges::copy_if(sample.bridge_releases, std::back_inserter(releases.bridge_releases), is_open);
    std::ranges::copy_if(sample.stiffness_reductions, std::back_inserter(releases.stiffness_reductions),
                         is_open);
    const auto& parameters = sample.parameters;
    fracture::TetrahedronSpan tetrahedra = fracture::span_of(subdomain);
    tetrahedra.material = sample.mesh.material;
    fracture::BreakableBody body(
        subdomain, fracture::make_material_field(parameters, 1, tetrahedra),
        fracture::make_release(parameters.fracture, {fracture::release_times(parameters, tetrahedra), 0}),
        parameters.surface_contact() ? input::Contact::frictionless : input::Contact::none);
    body.set_initial_strain(fracture::make_initial_strain(parameters, body.elasticity(), tetrahedra));
    body.set_time(sample.phase_start);
    for (auto& record : releases.breaks)
      if (record.load_time < sample.phase_start) record.phase_time = -infinity;
    body.restore(releases, sample.time[k]);
    std::vector<double> u(n_values);
    for (std::size_t i = 0; i < n_values; ++i) {
      const auto node = static_cast<std::size_t>(subdomain.layout.number[i / 3]);
      u[i] = static_cast<double>(sample.displacement[k * n_values + 3 * node + i % 3]);
    }
    // Contact ends where corners have moved apart by more than the longest edge.
    auto& stiffness = body.residual_stiffness();
    for (std::size_t c = 0; c < stiffness.contacts().size(); ++c) {
      double longest = 0, farthest = 0;
      for (const auto a : subdomain.tetrahedra[index(stiffness.contacts()[c])])
        for (const auto b : subdomain.tetrahedra[index(stiffness.contacts()[c])]) {
          longest = std::max(longest, norm(subdomain.nodes[index(a)] - subdomain.nodes[index(b)]));
          Vector apart{};
          for (std::size_t i = 0; i < 3; ++i) apart[i] = u[index(a, i)] - u[index(b, i)];
          farthest = std::max(farthest, norm(apart));
        }
      stiffness.cut_contact(c).is_apart = farthest > longest;
    }
    std::vector<mechanics::Symmetric> stress(subdomain.tetrahedra.size());
    for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
      const auto i = static_cast<std::size_t>(t);
      stress.at(static_cast<std::size_t>(subdomain.tetrahedron_number[i])) =
          body.residual_stiffness().stress(t, body.strain(t, u));
    }
    if (std::fwrite(stress.data(), sizeof(stress[0]), stress.size(), stdout) != stress.size())
      throw std::runtime_error("the stresses cannot be written");
  }
  if (std::fflush(stdout) != 0) throw std::runtime_error("the stresses cannot be written");
}

}  // namespace
}  // namespace crackle

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int status = 0;
  try {
    if (argc != 2) throw std::invalid_argument("usage: frame_stresses FILE");
    crackle::print_stresses(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "frame_stresses: %s\n", error.what());
    status = 1;
  }
  MPI_Finalize();
  return status;
}
