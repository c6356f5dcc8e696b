// SPDX-License-Identifier: GPL-3.0-or-later
// crackle mesh: makes one realization and writes it with its quality table.
#include "common/failure.h"
#include "common/quantity_text.h"
#include "common/regular_file.h"
#include "common/stopwatch.h"
#include "common/text_table.h"
#include "dynamics/stable_step.h"
#include "ensemble/base_points.h"
#include "ensemble/point_crew.h"
#include "ensemble/realization_queue.h"
#include "ensemble/sample_plan.h"
#include "fracture/variation.h"
#include "geometry/body.h"
#include "geometry/dual_facets.h"
#include "geometry/mesh_statistics.h"
#include "geometry/mother_points.h"
#include "geometry/partition.h"
#include "geometry/realization.h"
#include "geometry/subdomain.h"
#include "geometry/symmetry.h"
#include "input/reader.h"
#include "io/vtk_file.h"
#include "parallel/agreement.h"
#include "uncertainty/random_inputs.h"

#include "commands.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

struct MeshOptions {
  std::filesystem::path input;
  std::uint64_t sample = 0;
  int ranks = 1;
  std::filesystem::path output;
  std::filesystem::path dual_output;
  bool undisturbed = false;
};

struct MeshTimes {
  double base;         ///< of the mother points [s]
  double realization;  ///< [s]
};

std::string spread(const geometry::Quantiles& q, double unit, int digits) {
  return fmt::format("min {:.{}f}, 1 % {:.{}f}, median {:.{}f}, max {:.{}f}", q.smallest / unit, digits,
                     q.one_percent / unit, digits, q.median / unit, digits, q.largest / unit, digits);
}

std::string symmetry_text(const plane::Specimen& specimen, std::uint8_t symmetry) {
  if (symmetry == 0) return "none";
  return geometry::symmetry_of(*geometry::make_body(specimen), symmetry).name;
}

void add_partition(std::vector<NamedValue>& table, const geometry::Realization& realization, int n_ranks) {
  const Stopwatch clock;
  const geometry::Partition parts = geometry::partition(realization, n_ranks);
  const std::vector<geometry::Subdomain> subdomains = geometry::split(realization, parts);
  const double seconds = clock.seconds();
  std::int64_t n_computed = 0;
  std::int64_t n_ghosts = 0;
  for (const geometry::Subdomain& part : subdomains) {
    n_computed += part.n_tetrahedra();
    n_ghosts = std::max<std::int64_t>(n_ghosts, part.n_local() - part.layout.n_owned);
  }
  const auto n_tetrahedra = static_cast<double>(realization.tetrahedra.size());
  table.emplace_back(
      "partition",
      fmt::format("{} ranks: edge cut {} faces, imbalance {:.2f} %, {:.2f} % of the tetrahedra "
                  "computed twice or more, at most {} ghost nodes; {:.2f} s",
                  n_ranks, geometry::edge_cut(realization, parts), 100 * (parts.imbalance - 1),
                  100 * (static_cast<double>(n_computed) / n_tetrahedra - 1), n_ghosts, seconds));
}

/// The figures of one realization.
/// @param n_ranks ranks for the partition; 1: no partition
std::vector<NamedValue> mesh_table(const input::Parameters& parameters, std::uint64_t sample,
                                   const geometry::MotherPoints& base,
                                   const geometry::Realization& realization, const MeshTimes& times,
                                   int n_ranks) {
  const geometry::MeshStatistics statistics = geometry::mesh_statistics(realization);
  const double degree = std::numbers::pi / 180;
  std::vector<NamedValue> table;
  table.emplace_back("sample", fmt::format("{} of seed {}", sample, parameters.seed));
  table.emplace_back("nodes", fmt::format("{}", realization.nodes.size()));
  table.emplace_back("tetrahedra", fmt::format("{}", realization.tetrahedra.size()));
  table.emplace_back("edges", fmt::format("{}", statistics.n_edges));
  table.emplace_back("boundary triangles", fmt::format("{}", realization.boundary.size()));
  for (auto& row : face_rows(parameters.specimen)) table.push_back(std::move(row));
  const auto materials = material_rows(parameters, realization);
  table.insert(table.end(), materials.begin(), materials.end());
  const auto of_length = [](const geometry::Quantiles& lengths) {
    const ShownUnit unit = shown_unit({"mm", 1e3}, "m", lengths.largest);
    return spread(lengths, 1 / unit.factor, 3) + " " + unit.name;
  };
  table.emplace_back("spacing", of_length(geometry::quantiles(base.spacing)));
  table.emplace_back("edge length", of_length(statistics.edge_length));
  table.emplace_back("quality", spread(statistics.quality, 1, 4));
  table.emplace_back("dihedral angles",
                     fmt::format("{:.1f} to {:.1f} degrees", statistics.smallest_angle / degree,
                                 statistics.largest_angle / degree));
  const dynamics::StableStep stable = dynamics::stable_step(parameters, realization);
  table.emplace_back("stable step", quantity_text(stable.step, "s"));
  if (stable.mass_scaling) table.emplace_back("mass scaling", dynamics::to_string(*stable.mass_scaling));
  table.emplace_back("redrawn points",
                     fmt::format("{} ({:.2f} %) in {} rounds", realization.report.redrawn_points,
                                 100 * static_cast<double>(realization.report.redrawn_points) /
                                     static_cast<double>(realization.nodes.size()),
                                 realization.report.rounds));
  table.emplace_back("symmetry", symmetry_text(parameters.specimen, realization.report.symmetry));
  table.emplace_back("time", fmt::format("{:.2f} s for the realization, {:.2f} s for the base points",
                                         times.realization, times.base));
  if (n_ranks > 1) add_partition(table, realization, n_ranks);
  return table;
}

/// Makes the realization, prints its table and writes the files.
void make_mesh(const input::Parameters& ensemble, const MeshOptions& options, ensemble::PointCrew& crew) {
  input::Parameters parameters = uncertainty::sample_parameters(ensemble, options.sample);
  if (options.undisturbed) parameters.mesh.perturbation = 0;
  MeshTimes times{};
  const auto body = geometry::make_body(parameters);
  geometry::MotherPoints base;
  const auto make_base = [&](int attempt) {
    const Stopwatch base_clock;
    base = ensemble::make_base_points(*body, parameters.mesh, parameters.seed, notify, options.sample,
                                      attempt, crew.for_task({options.sample, attempt}));
    times.base += base_clock.seconds();
  };
  const bool is_own = parameters.mesh.base == input::Base::own;
  const Stopwatch clock;
  if (!is_own) make_base(0);
  // The attempts of a run.
  geometry::Realization realization = ensemble::with_retries([&](std::uint64_t sample, int attempt) {
    if (is_own) make_base(attempt);
    return geometry::make_realization(*body, base, parameters.mesh, parameters.seed, sample, attempt);
  })(options.sample);
  ensemble::complete_realization(parameters, *body, options.sample, realization);
  times.realization = clock.seconds() - times.base;
  std::vector<double> strength_factors;
  if (parameters.fracture.variation)
    strength_factors =
        fracture::strength_factors(parameters, options.sample, {realization.nodes, realization.tetrahedra});
  auto rows = mesh_table(parameters, options.sample, base, realization, times, options.ranks);
  if (!strength_factors.empty())
    rows.emplace_back("strength factor", spread(geometry::quantiles(strength_factors), 1, 3));
  io::write_vtk_mesh(options.output, realization, *body, parameters.mesh, base, std::move(strength_factors));
  rows.emplace_back("written", options.output.string());
  if (!options.dual_output.empty()) {
    io::write_vtk_dual_surface(options.dual_output, geometry::dual_surface(realization));
    rows.emplace_back("written", options.dual_output.string());
  }
  fmt::print("{}", aligned(rows, "  "));
}

/// Only what an earlier call may have written is replaced.
void refuse_other_file(const std::filesystem::path& file) {
  if (file.empty() || !is_taken(file) || !other_kind(file).empty()) return;  // writing refuses those
  constexpr std::string_view signature = "\x89HDF";
  std::string start(signature.size(), '\0');
  std::ifstream(file, std::ios::binary).read(start.data(), static_cast<std::streamsize>(start.size()));
  if (start != signature) fail("{} exists and is no VTKHDF file; give another name", file.string());
}

int run_mesh(const parallel::Communicator& world, const MeshOptions& options) {
  const input::Parameters parameters = read_given_input(world, options.input);
  refuse_sweep(parameters, options.input);
  ensemble::PointCrew crew(world);
  const auto make = [&] {
    ensemble::require_sample(parameters.ensemble, options.sample);
    for (const auto& file : {options.output, options.dual_output}) refuse_other_file(file);
    if (!options.dual_output.empty() &&
        weakly_canonical(options.dual_output) == weakly_canonical(options.output))
      fail("{} is to hold the mesh; give --dual-facets another name", options.output.string());
    make_mesh(parameters, options, crew);
  };
  crew.agree_on_root(make, [&](const ensemble::PointTask& task, std::vector<input::MeshRegion> regions) {
    const input::Parameters own = uncertainty::sample_parameters(parameters, task.subject);
    input::Mesh mesh = own.mesh;
    mesh.regions = std::move(regions);
    geometry::help_mother_points(*geometry::make_body(own), mesh, own.seed, task.subject, task.attempt, crew);
  });
  return success;
}

}  // namespace

void add_mesh_command(CLI::App& app, Action& run) {
  const auto options = std::make_shared<MeshOptions>();
  CLI::App* const command = app.add_subcommand(
      "mesh", "Make one realization, print its quality table and write it as a VTKHDF file");
  command->add_option("input", options->input, "input file (TOML)")->required();
  add_sample_option(*command, options->sample)->capture_default_str();
  command
      ->add_option("--ranks", options->ranks, "number of ranks for which the table describes the partition")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "VTKHDF file to write; an existing one is replaced")
      ->required();
  command->add_option("--dual-facets", options->dual_output,
                      "also write the candidate crack facets, as quadrilaterals, to this file");
  command->add_flag("--undisturbed", options->undisturbed,
                    "the mesh of the mother points, before their perturbation");
  command->footer("crackle-survey makes statistics over many realizations.");
  command->callback([options, &run] {
    run.work = [options](const parallel::Communicator& world) { return run_mesh(world, *options); };
  });
}

}  // namespace crackle::apps
