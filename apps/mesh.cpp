// SPDX-License-Identifier: GPL-3.0-or-later
// crackle mesh: makes one realization and writes it with its quality table.
#include "commands.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/dual_facets.h"
#include "crackle/geometry/mesh_statistics.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"
#include "crackle/io/vtk_file.h"
#include "crackle/parallel/agreement.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>

namespace crackle::apps {

namespace {

struct Options {
  std::filesystem::path input;
  std::uint64_t sample = 0;
  std::filesystem::path output;
  std::filesystem::path dual_output;
};

class Stopwatch {
public:
  /// Seconds since the last call or the construction.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct Times {
  double base;
  double realization;
};

std::string table(const Options& options, const input::Parameters& parameters,
                  const geometry::Realization& realization, const Times& times) {
  const geometry::MeshStatistics statistics = geometry::mesh_statistics(realization);
  std::string text;
  const auto row = [&](const char* name, const std::string& value) {
    text += fmt::format("{:<20} {}\n", name, value);
  };
  const auto spread = [](const geometry::Quantiles& q, double unit, int digits) {
    return fmt::format("min {:.{}f}, 1 % {:.{}f}, median {:.{}f}, max {:.{}f}", q.smallest / unit, digits,
                       q.one_percent / unit, digits, q.median / unit, digits, q.largest / unit, digits);
  };
  const double degree = std::numbers::pi / 180;
  row("sample", fmt::format("{} of seed {}", options.sample, parameters.ensemble.seed));
  row("nodes", fmt::format("{}", realization.nodes.size()));
  row("tetrahedra", fmt::format("{}", realization.tetrahedra.size()));
  row("edges", fmt::format("{}", statistics.n_edges));
  row("boundary triangles", fmt::format("{}", realization.boundary.size()));
  row("edge length", spread(statistics.edge_length, 1e-3, 3) + " mm");
  row("quality", spread(statistics.quality, 1, 4));
  row("dihedral angles", fmt::format("{:.1f} to {:.1f} degrees", statistics.smallest_angle / degree,
                                     statistics.largest_angle / degree));
  row("stable step", fmt::format("{:.4g} ns", dynamics::stable_step(parameters, realization) / 1e-9));
  row("redrawn points", fmt::format("{} ({:.2f} %) in {} rounds", realization.report.redrawn_points,
                                    100 * static_cast<double>(realization.report.redrawn_points) /
                                        static_cast<double>(realization.nodes.size()),
                                    realization.report.rounds));
  row("time", fmt::format("{:.2f} s for the realization, {:.2f} s for the base points", times.realization,
                          times.base));
  return text;
}

/// Makes the realization, prints its table and writes the files.
void make_mesh(const input::Parameters& parameters, const Options& options) {
  Stopwatch stopwatch;
  Times times{};
  const geometry::Body body(parameters.specimen);
  const geometry::MotherPoints base =
      geometry::make_mother_points(body, parameters.mesh, parameters.ensemble.seed);
  times.base = stopwatch.lap();
  const geometry::Realization realization =
      geometry::make_realization(body, base, parameters.mesh, parameters.ensemble.seed, options.sample);
  times.realization = stopwatch.lap();
  fmt::print("{}", table(options, parameters, realization, times));
  io::write_vtk_mesh(options.output, realization);
  fmt::print("{:<20} {}\n", "written", options.output.string());
  if (options.dual_output.empty()) return;
  io::write_vtk_dual_surface(options.dual_output, geometry::dual_surface(realization));
  fmt::print("{:<20} {}\n", "written", options.dual_output.string());
}

int run_mesh(const parallel::Communicator& world, const Options& options) {
  const input::Parameters parameters = read_input(world, options.input);
  parallel::agree(world, [&] {
    if (world.is_root()) make_mesh(parameters, options);
  });
  return success;
}

}  // namespace

void add_mesh_command(CLI::App& app, Action& run) {
  const auto options = std::make_shared<Options>();
  CLI::App* const command = app.add_subcommand(
      "mesh", "Make one realization; write it as a VTKHDF file and print its quality table");
  command->add_option("input", options->input, "input file (TOML)")->required();
  command->add_option("--sample", options->sample, "number of the realization")
      ->check([](const std::string& text) {
        return text.starts_with('-') ? std::string("a sample number is 0 or more") : std::string();
      })
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "file to write; an existing one is replaced")
      ->required();
  command->add_option("--dual-facets", options->dual_output,
                      "also write the candidate crack facets, as quadrilaterals, to this file");
  command->callback([options, &run] {
    run = [options](const parallel::Communicator& world) { return run_mesh(world, *options); };
  });
}

}  // namespace crackle::apps
