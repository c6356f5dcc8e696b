// SPDX-License-Identifier: GPL-3.0-or-later
// crackle check: validates an input file and says what running it will take.
#include "commands.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/cost_model.h"
#include "crackle/ensemble/estimate.h"
#include "crackle/ensemble/memory.h"
#include "crackle/fracture/tuler_butcher.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/reader.h"
#include "crackle/parallel/agreement.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

struct CheckOptions {
  std::string file;
  bool keys = false;
  std::int64_t ranks = 0;  ///< to plan for; 0: no plan
};

std::string aligned(const std::vector<std::pair<std::string, std::string>>& rows) {
  std::size_t width = 0;
  for (const auto& row : rows) width = std::max(width, row.first.size());
  std::string text;
  for (const auto& [name, value] : rows) text += fmt::format("{:<{}} = {}\n", name, width, value);
  return text;
}

std::string duration_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  return seconds < 7200 ? fmt::format("{:.3g} min", seconds / 60) : fmt::format("{:.3g} h", seconds / 3600);
}

/// How many ranks should share a sample, by the cost model.
std::string plan_text(const geometry::Realization& realization, const input::Parameters& parameters,
                      const ensemble::Estimate& estimate, std::int64_t n_ranks) {
  const auto plans = ensemble::make_plans(realization, parameters, estimate.force_evaluations,
                                          ensemble::Machine(parameters.time.precision), n_ranks,
                                          parameters.ensemble.samples);
  const double forces_per_step =
      static_cast<double>(estimate.force_evaluations) / static_cast<double>(estimate.steps);
  std::string text = fmt::format(
      "\nPlans for {} rank{} and {} samples (src/ensemble/README.md has the model):\n"
      "{:>16} {:>8} {:>16} {:>12} {:>13} {:>8} {:>9} {:>9} {:>10}\n",
      n_ranks, n_ranks == 1 ? "" : "s", parameters.ensemble.samples, "ranks per sample", "groups",
      "tetrahedra/rank", "ghosts/rank", "time per step", "exchange", "sample", "ensemble", "efficiency");
  for (const auto& plan : plans) {
    const double step = forces_per_step * plan.force.total();
    text += fmt::format("{:>16} {:>8} {:>16} {:>12} {:>10.3f} ms {:>6.1f} % {:>9} {:>9} {:>8.0f} %{}\n",
                        plan.share.ranks, plan.groups, plan.share.tetrahedra, plan.share.ghosts, 1e3 * step,
                        100 * (plan.force.exchange + plan.force.looks) / plan.force.total(),
                        duration_text(plan.sample_seconds), duration_text(plan.wall_seconds),
                        100 * plan.efficiency, plan.waits_for_master ? "  groups wait for meshes" : "");
  }
  const auto& best = ensemble::recommended(plans);
  text += fmt::format("recommended: ensemble.ranks_per_sample = {}\n", best.share.ranks);
  if (best.waits_for_master)
    text +=
        "One master makes meshes too slowly for so many groups: run ranges of the samples as a job array "
        "(jobs/array.sbatch).\n";
  return text;
}

ensemble::GroupLayout layout_of_sample(const input::Parameters& parameters) {
  return ensemble::one_group(parameters.ensemble.ranks_per_sample);
}

/// Of all ranks that share a sample [byte].
double sample_memory(const input::Parameters& parameters, const ensemble::MemoryDemand& demand) {
  return demand.master + (parameters.ensemble.ranks_per_sample - 1) * demand.member;
}

std::string estimate_text(const input::Parameters& parameters, std::int64_t plan_ranks) {
  const geometry::Body body(parameters.specimen);
  // Only the mesh is made here; where the samples are computed there may be more memory, or more nodes.
  const auto available = ensemble::available_memory();
  if (const auto message =
          ensemble::shortage(ensemble::expected_mesh_memory(parameters, body), "making the mesh", available))
    throw std::runtime_error(*message + "; take coarser spacings, or check the input where there is more");
  const std::uint64_t seed = parameters.ensemble.seed;
  const auto base = ensemble::make_base_points(body, parameters, tell);
  const auto realization = geometry::make_realization(body, base, parameters.mesh, seed, 0);
  const double stable_step = dynamics::stable_step(parameters, realization);
  const auto n_nodes = static_cast<std::int64_t>(realization.nodes.size());
  const auto n_tetrahedra = static_cast<std::int64_t>(realization.tetrahedra.size());
  const auto estimate = ensemble::make_estimate(parameters, n_tetrahedra, stable_step);
  const double memory = sample_memory(
      parameters, ensemble::memory_demand(parameters, static_cast<double>(n_nodes),
                                          static_cast<double>(n_tetrahedra), layout_of_sample(parameters)));
  const int n_samples = parameters.ensemble.samples;
  const int n_ranks = parameters.ensemble.ranks_per_sample;
  const auto n_faces = static_cast<std::int64_t>(realization.boundary.size());
  std::vector<std::pair<std::string, std::string>> rows{
      {"nodes", fmt::format("{}", n_nodes)},
      {"tetrahedra", fmt::format("{} (worst quality {:.3f})", n_tetrahedra, realization.report.min_quality)},
      {"boundary triangles", fmt::format("{}", n_faces)},
      {"stable step", fmt::format("{:.4g} ns", stable_step * 1e9)},
      {"time step", fmt::format("{:.4g} ns", estimate.step * 1e9)},
      {"steps", fmt::format("{} per sample", estimate.steps)},
      {"force evaluations", fmt::format("{} per sample", estimate.force_evaluations)},
      {"memory", fmt::format("{:.0f} MB per sample, on {} rank{}; {:.3g} GB are available here", memory / 1e6,
                             n_ranks, n_ranks == 1 ? "" : "s", available.bytes / 1e9)},
      {"core-hours", fmt::format("{:.3g} for {} sample{} of one dynamic phase each, at {:.0f} million "
                                 "tetrahedron updates per second and core",
                                 estimate.core_hours, n_samples, n_samples == 1 ? "" : "s",
                                 ensemble::updates_per_core_second(parameters.time.precision) / 1e6)},
  };
  if (parameters.fracture.memory == input::Memory::step && parameters.fracture.toughness == 0) {
    const double strength = fracture::TulerButcher(parameters.fracture, 1, estimate.step).strength(0);
    rows.emplace_back("strength", fmt::format("{:.4g} MPa, which breaks in one step", strength / 1e6));
  }
  std::string text = aligned(rows);
  const std::string whose = n_ranks == 1 ? "a sample" : fmt::format("the {} ranks of a sample", n_ranks);
  if (const auto message = ensemble::shortage(memory, whose, available)) {
    text += fmt::format(
        "\nWarning: not to be computed here: {}; elsewhere, or with coarser spacings, more nodes, or more "
        "ranks_per_sample\n",
        *message);
  }
  if (plan_ranks > 0) text += plan_text(realization, parameters, estimate, plan_ranks);
  return text;
}

int check(const parallel::Communicator& world, const std::string& file, std::int64_t plan_ranks) {
  const input::Parameters parameters = read_input(world, file);
  parallel::agree(world, [&] {
    if (!world.is_root()) return;
    if (parameters.mesh.points)
      geometry::read_points(*parameters.mesh.points, geometry::Body(parameters.specimen));
    fmt::print("{} is valid\n\n{}\nThe mesh of sample 0 and what the ensemble takes:\n", file,
               input::echo(parameters));
    std::fflush(stdout);
    try {
      fmt::print("{}", estimate_text(parameters, plan_ranks));
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{}: {}", file, error.what()));
    }
  });
  return success;
}

}  // namespace

void add_check_command(CLI::App& app, Action& run) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand(
      "check", "Validate an input file; print the resolved values and what running them will take");
  command->add_option("input", options->file, "input file (TOML)");
  command->add_flag("--keys", options->keys, "print the table of all input keys (Markdown) instead");
  command
      ->add_option("--ranks", options->ranks,
                   "plan for this many ranks: how many should share a sample, and how long it takes")
      ->check(CLI::Range(1, 10'000'000));
  command->callback([options, &run] {
    if (options->keys != options->file.empty()) {
      throw CLI::ValidationError("check takes either an input file or --keys");
    }
    run = [options](const parallel::Communicator& world) {
      if (!options->keys) return check(world, options->file, options->ranks);
      if (world.is_root()) fmt::print("{}", input::key_table());
      return static_cast<int>(success);
    };
  });
}

}  // namespace crackle::apps
