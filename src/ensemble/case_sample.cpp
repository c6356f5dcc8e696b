// SPDX-License-Identifier: GPL-3.0-or-later
#include "case_sample.h"

#include "common/real.h"
#include "cracks/crack_surface.h"
#include "cracks/space_forks.h"
#include "ensemble/base_points.h"
#include "fracture/material_field.h"
#include "geometry/partition.h"
#include "input/reader.h"
#include "io/checkpoint_file.h"
#include "io/sample_file.h"
#include "parallel/agreement.h"
#include "uncertainty/random_inputs.h"

#include <system_error>
#include <utility>

namespace crackle::ensemble {

const input::Parameters& CaseSample::parameters() {
  if (case_.parameters().random.empty()) return case_.parameters();
  if (!drawn_) drawn_ = uncertainty::sample_parameters(case_.parameters(), sample_);
  return *drawn_;
}

const geometry::Body& CaseSample::body() {
  if (case_.parameters().random.empty()) return case_.body();
  if (!drawn_body_) drawn_body_ = geometry::make_body(parameters());
  return *drawn_body_;
}

geometry::Realization CaseSample::make() {
  return make_sample_realization(body(), case_.base(), parameters(), sample_);
}

std::vector<geometry::Subdomain> CaseSample::split(const geometry::Realization& realization, int n_parts) {
  return geometry::split(realization, geometry::partition(realization, n_parts),
                         parameters().fracture.length);
}

dynamics::SampleResult CaseSample::compute(const parallel::Communicator& group,
                                           const geometry::Subdomain& subdomain,
                                           dynamics::SampleControl control) {
  n_ranks_ = group.size();
  control.sample = sample_;
  if (!case_.parameters().random.empty()) parallel::agree(group, [&] { parameters(); });
  return case_.mechanics()(group, parameters(), parameters().output, subdomain, control);
}

SampleAnalysis CaseSample::analyse(const geometry::Realization& realization,
                                   const dynamics::SampleResult& result) {
  const geometry::Body& own_body = body();
  const input::Parameters& own = parameters();
  SampleAnalysis analysis;
  analysis.surface = cracks::make_crack_surface(own_body, realization, result.breaks, result.phase_start);
  // Lines and trajectories are those of cracks in a plate.
  const bool is_plate = !own_body.outline().empty();
  if (is_plate) {
    analysis.branches = cracks::find_branches(own_body, analysis.surface);
    analysis.lines = cracks::crack_lines(own_body, analysis.surface, analysis.branches);
  } else {
    analysis.branches.points = cracks::find_forks(realization, analysis.surface);
  }
  analysis.crossings = cracks::section_crossings(own_body, analysis.surface, analysis.branches,
                                                 cracks::planes_of(own.sections));
  const auto material = fracture::make_material_field(
      own, sample_,
      {realization.nodes, realization.tetrahedra, {}, realization.material, realization.map_factor});
  const auto waves = cracks::rayleigh_speeds(analysis.surface, realization, material);
  std::vector<cracks::FrontTrajectory> trajectories;
  if (is_plate) trajectories = cracks::front_trajectories(own_body, analysis.surface, waves);
  analysis.summary = analysis::summarize(own_body, result, analysis.surface, analysis.lines,
                                         analysis.branches, analysis.crossings, trajectories);
  analysis.summary.crack_area_in =
      analysis::crack_area_in_parts(analysis.surface, realization, own.materials, own.interfaces);
  analysis.summary.long_branching_points =
      analysis.branches.n_in_space(analysis::branch_length(own.output.branch_length, own.mesh, own_body));
  analysis.summary.traces =
      cracks::start_traces(analysis.surface, own.sections.planes, own_body.crack_starts().size());
  analysis.summary.fragments = analysis::summarize_fragments(result);
  if (own.draw) analysis.summary.inputs = own.draw->values;
  analysis.history = cracks::crack_history(own_body, analysis.surface, result, trajectories, waves);
  return analysis;
}

void CaseSample::write_file(const PartialSample& content, const analysis::SampleSummary& summary) {
  const auto& [realization, result, analysis] = content;
  io::write_sample(io::sample_path(case_.folder(), sample_),
                   {parameters(), sample_, realization, result, analysis.surface, analysis.lines,
                    analysis.branches, analysis.crossings, summary, analysis.history, n_ranks_});
}

void CaseSample::write(const geometry::Realization& realization, const dynamics::SampleResult& result,
                       const SampleAnalysis& analysis) {
  case_.mark().require();
  write_file({realization, result, analysis}, analysis.summary);
}

void CaseSample::write_failure(const analysis::SampleSummary& failure, const PartialSample* partial) {
  case_.mark().require();
  if (partial != nullptr)
    write_file(*partial, failure);
  else
    io::write_failed_sample(io::sample_path(case_.folder(), sample_), case_.parameters(), sample_, failure);
}

analysis::SampleSummary CaseSample::failure_row(const std::string& reason) {
  const input::Study& ensemble = case_.parameters();
  auto row = analysis::empty_summary(static_cast<int>(case_.body().crack_starts().size()),
                                     static_cast<int>(ensemble.sections.size()),
                                     analysis::SampleStatus::failed, reason);
  try {
    row.inputs = uncertainty::drawn_values(ensemble, sample_);
  } catch (...) {  // may be the cause of the failure
    row.inputs.assign(ensemble.random.size(), not_a_number);
  }
  return row;
}

std::vector<std::byte> CaseSample::read_checkpoint() {
  // Bad checkpoints were renamed at the start of the run; one that has become unreadable since is ignored.
  try {
    const std::filesystem::path file = io::checkpoint_path(case_.folder(), sample_);
    if (std::filesystem::exists(file))
      return io::read_checkpoint(file, input::sample_identity(case_.parameters()), sample_);
  } catch (const std::exception&) {
  }
  return {};
}

void CaseSample::write_checkpoint(std::span<const std::byte> bytes) {
  case_.mark().require();
  io::write_checkpoint(io::checkpoint_path(case_.folder(), sample_),
                       input::sample_identity(case_.parameters()), sample_, bytes);
}

void CaseSample::remove_checkpoint() {
  std::error_code ignored;
  std::filesystem::remove(io::checkpoint_path(case_.folder(), sample_), ignored);
}

}  // namespace crackle::ensemble
