// SPDX-License-Identifier: GPL-3.0-or-later
// crackle mesh: makes one realization and writes it with its quality table, or surveys many.
#include "crackle/common/failure.h"
#include "crackle/common/regular_file.h"
#include "crackle/common/stopwatch.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/material_map.h"
#include "crackle/ensemble/realization_queue.h"
#include "crackle/ensemble/sample_plan.h"
#include "crackle/fracture/variation.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/dual_facets.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"
#include "crackle/io/vtk_file.h"
#include "crackle/parallel/agreement.h"
#include "crackle/uncertainty/random_inputs.h"

#include "commands.h"
#include "mesh_tables.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
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
  std::uint64_t n_surveyed = 0;
  std::filesystem::path survey_table;
};

/// Makes the realization, prints its table and writes the files.
void make_mesh(const input::Parameters& ensemble, const MeshOptions& options) {
  const input::Parameters parameters = uncertainty::sample_parameters(ensemble, options.sample);
  MeshTimes times{};
  const auto body = geometry::make_body(parameters);
  geometry::MotherPoints base;
  const auto make_base = [&](int attempt) {
    const Stopwatch base_clock;
    base = ensemble::make_base_points(*body, parameters, notify, options.sample, attempt);
    times.base += base_clock.seconds();
  };
  const bool is_own = parameters.mesh.base == input::Base::own;
  const Stopwatch clock;
  if (!is_own) make_base(0);
  // The attempts of a run.
  geometry::Realization realization = ensemble::with_retries([&](std::uint64_t sample, int attempt) {
    if (is_own) make_base(attempt);
    return geometry::make_realization(*body, base, parameters.mesh, parameters.ensemble.seed, sample,
                                      attempt);
  })(options.sample);
  ensemble::apply_material_map(parameters, *body, options.sample, realization);
  times.realization = clock.seconds() - times.base;
  std::vector<double> strength_factors;
  if (parameters.fracture.variation)
    strength_factors =
        fracture::strength_factors(parameters, options.sample, {realization.nodes, realization.tetrahedra});
  auto rows = mesh_table(parameters, options.sample, base, realization, times, options.ranks);
  if (!strength_factors.empty()) rows.push_back(variation_row(strength_factors));
  io::write_vtk_mesh(options.output, realization, *body, parameters.mesh, std::move(strength_factors));
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
  int status = success;
  parallel::agree_on_root(world, [&] {
    ensemble::require_sample(parameters, options.sample);
    for (const auto& file : {options.output, options.dual_output}) refuse_other_file(file);
    if (options.n_surveyed == 0) {
      make_mesh(parameters, options);
    } else if (!survey_meshes(parameters, options.n_surveyed, options.survey_table)) {
      status = some_samples_failed;
    }
  });
  return status;
}

}  // namespace

void add_mesh_command(CLI::App& app, Action& run) {
  const auto options = std::make_shared<MeshOptions>();
  CLI::App* const command = app.add_subcommand("mesh",
                                               "Make one realization, print its quality table and write it "
                                               "as a VTKHDF file on request; or survey many");
  command->add_option("input", options->input, "input file (TOML)")->required();
  CLI::Option* const sample = add_sample_option(*command, options->sample)->capture_default_str();
  CLI::Option* const ranks = command
                                 ->add_option("--ranks", options->ranks,
                                              "number of ranks for which the table describes the partition")
                                 ->check(CLI::Range(1, 100000))
                                 ->capture_default_str();
  CLI::Option* const output = command->add_option("-o,--output", options->output,
                                                  "VTKHDF file to write; an existing one is replaced");
  CLI::Option* const dual_output =
      command->add_option("--dual-facets", options->dual_output,
                          "also write the candidate crack facets, as quadrilaterals, to this file");
  CLI::Option* const survey =
      command
          ->add_option("--survey", options->n_surveyed,
                       "make this many realizations, starting with number 0, and print statistics over all "
                       "of them: conformity, quality, bias, time; writes no mesh")
          ->check(CLI::Range(1, 1000000))
          ->excludes(sample, ranks, output, dual_output);
  command
      ->add_option("--table", options->survey_table,
                   "with --survey: also write a CSV file with one line for each realization")
      ->needs(survey);
  command->footer("Exit status: 0 done; 1 usage or input error; 2 some surveyed realizations failed.");
  command->callback([options, output, survey, &run] {
    if (output->count() + survey->count() == 0) throw CLI::RequiredError("--output or --survey");
    run.work = [options](const parallel::Communicator& world) { return run_mesh(world, *options); };
  });
}

}  // namespace crackle::apps
