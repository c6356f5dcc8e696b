// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/sample_summary.h"

#include "analysis/result_list.h"
#include "analysis/statistics.h"
#include "common/index.h"
#include "common/packing.h"
#include "common/quantity_text.h"
#include "cracks/crack_pattern.h"
#include "cracks/crack_speed.h"
#include "dynamics/resolution.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <type_traits>
#include <utility>

namespace crackle::analysis {

namespace {

double traced_length(const std::vector<cracks::CrackLine>& lines) {
  double length = 0;
  for (const cracks::CrackLine& line : lines)
    for (std::size_t i = 1; i < line.points.size(); ++i)
      length += std::hypot(line.points[i].y - line.points[i - 1].y, line.points[i].z - line.points[i - 1].z);
  return length;
}

void set_crossings(const std::vector<cracks::SectionCrossing>& crossings, SampleSummary& row) {
  row.position.clear();
  row.z_spread.clear();
  row.arrival_time.clear();
  row.branches.clear();
  for (const cracks::SectionCrossing& crossing : crossings) {
    row.position.push_back(crossing.position);
    row.z_spread.push_back(crossing.spread);
    row.arrival_time.push_back(crossing.arrival);
    row.branches.push_back(static_cast<std::int32_t>(crossing.branches.size()));
  }
}

/// Leaves out the results that need a plate, in whose plane cracks are followed.
void forget_paths(SampleSummary& row) {
  for_each_result([&](const ResultInfo& info, auto member) {
    using Value = std::remove_reference_t<decltype(row.*member)>;
    if (info.about != About::path && info.about != About::hole) return;
    row.*member =
        std::numeric_limits<Value>::has_quiet_NaN ? std::numeric_limits<Value>::quiet_NaN() : Value(-1);
  });
}

constexpr double clearly_below = 0.9;

bool has_onset(const SampleSummary& row) {
  return row.status == SampleStatus::done && !std::isnan(row.onset_force) && !std::isnan(row.peak_load);
}

/// True if the load was clearly higher before the last dynamic phase: the onset is not what a test would
/// record. That of a held sample rose after it.
bool has_late_onset(const SampleSummary& row) {
  return has_onset(row) && !is_held(row) && row.onset_force < clearly_below * row.peak_load;
}

std::optional<std::string> fast_crack_warning(std::span<const SampleSummary> samples) {
  const auto n = std::ranges::count_if(samples, [](const SampleSummary& row) {
    return row.status == SampleStatus::done && row.crack_speed_ratio > usual_speed_ratio;
  });
  if (n == 0) return std::nullopt;
  return fmt::format(
      "warning: in {} a crack runs at more than {:g} times the Rayleigh speed of its material, which "
      "experiments hardly ever show: more energy is released than the cracks consume",
      count_text(n, "sample"), usual_speed_ratio);
}

/// If the load was clearly higher before the last dynamic phase, in any sample: the onset is not what a test
/// would record.
std::optional<std::string> onset_warning(std::span<const SampleSummary> samples) {
  const auto n_below = std::ranges::count_if(samples, has_late_onset);
  if (n_below == 0) return std::nullopt;
  return fmt::format(
      "warning: in {} of {} the load was more than {:.0f} % higher before the last dynamic phase, "
      "whose start is the onset: cracks had run and stopped; the peak load is what the body held",
      n_below, count_text(std::ranges::count_if(samples, has_onset), "sample"), 100 / clearly_below - 100);
}

}  // namespace

SampleSummary empty_summary(int n_starts, int n_sections, SampleStatus status, std::string error) {
  SampleSummary row;
  row.status = status;
  row.error = std::move(error);
  const std::size_t n = static_cast<std::size_t>(n_starts) * static_cast<std::size_t>(n_sections);
  for_each_position_result([&](const ResultInfo&, auto member) {
    using Value = typename std::remove_reference_t<decltype(row.*member)>::value_type;
    (row.*member)
        .assign(n, std::numeric_limits<Value>::has_quiet_NaN ? std::numeric_limits<Value>::quiet_NaN() : 0);
  });
  return row;
}

SampleSummary summarize(const geometry::Body& body, const dynamics::SampleResult& result,
                        const cracks::CrackSurface& surface, const std::vector<cracks::CrackLine>& lines,
                        const cracks::CrackBranches& branches,
                        const std::vector<cracks::SectionCrossing>& crossings,
                        std::span<const cracks::FrontTrajectory> trajectories) {
  SampleSummary row;
  row.status = SampleStatus::done;
  row.note = result.note;
  row.first_break_time = result.first_break_time;
  row.first_break_load = result.first_break_load;
  if (!surface.facets.empty())
    std::tie(row.first_break_x, row.first_break_y, row.first_break_z) =
        std::tuple_cat(surface.facets.front().corner[2]);  // centroid of the first broken tetrahedron
  row.onset_time = result.onset_time;
  row.onset_force = result.onset_force;
  row.peak_load = result.loads.peak_load;
  row.displacement_at_peak = result.loads.displacement_at_peak;
  row.work_of_fracture = result.loads.work_of_fracture;
  row.dynamic_phases = static_cast<std::int32_t>(result.counts.dynamic_phases);
  if (!std::isnan(result.phase_start)) row.crack_area_before_onset = surface.area_before_phase();
  row.outcome = static_cast<std::int32_t>(result.outcome);
  row.held = result.outcome == dynamics::Outcome::arrested && result.loads.end_at_peak ? 1 : 0;
  row.pattern = static_cast<std::int32_t>(cracks::classify(body, surface));
  row.leading_start = cracks::leading_start(body, surface);
  const cracks::LeadersHole met = cracks::leaders_hole(body, surface, row.leading_start);
  row.hole = met.hole;
  row.hole_passage = static_cast<std::int32_t>(met.passage);
  row.overlap = cracks::pattern_overlap(body, surface);
  row.branching_points = branches.n_in_space();
  row.branching_points_projected = branches.n_projected();
  row.kinks = cracks::count_kinks(lines);
  row.breaks = static_cast<std::int64_t>(result.breaks.size());
  row.crack_area = surface.area();
  const cracks::CrackSpeed speed = cracks::max_crack_speed(body, trajectories);
  row.crack_speed_max = speed.largest;
  row.crack_speed_ratio = speed.largest_ratio;
  row.energy_error = result.energy_error;
  row.equilibrium_residual = result.equilibrium_residual;
  row.traced_area = body.size()[0] * traced_length(lines);
  row.effective_toughness = row.traced_area > 0 && !result.energy.empty()
                                ? result.energy.back().released / row.traced_area
                                : not_a_number;
  set_crossings(crossings, row);
  if (body.outline().empty()) forget_paths(row);
  const dynamics::SampleTimings& timings = result.timings;
  row.wall_time = timings.mesh + timings.setup + timings.quasi_static + timings.dynamic;
  return row;
}

double branch_length(double given, const input::Mesh& mesh, const geometry::Body& body) {
  constexpr double n_spacings = 4;
  if (given > 0) return given;
  return n_spacings * dynamics::crack_spacing(mesh, body).greatest;
}

std::vector<std::string> crack_parts(const std::vector<input::Material>& materials,
                                     const std::vector<input::Interface>& interfaces) {
  std::vector<std::string> names;
  if (materials.size() == 1) return names;
  for (const input::Material& material : materials) names.push_back(material.name);
  for (const input::Interface& one : interfaces)
    names.push_back(fmt::format("interface {}-{}", one.between[0], one.between[1]));
  return names;
}

std::vector<double> crack_area_in_parts(const cracks::CrackSurface& surface,
                                        const geometry::Realization& realization,
                                        const std::vector<input::Material>& materials,
                                        const std::vector<input::Interface>& interfaces) {
  std::vector<double> areas(crack_parts(materials, interfaces).size(), 0.0);
  if (areas.empty()) return areas;
  for (const cracks::CrackFacet& facet : surface.facets) {
    const auto t = index(facet.tetrahedron);
    const std::size_t interface = realization.interface.empty() ? 0 : realization.interface[t];
    const std::size_t material = realization.material.empty() ? 0 : realization.material[t];
    areas[interface > 0 ? materials.size() + interface - 1 : material] += facet.area;
  }
  return areas;
}

std::vector<double> fragment_shares() {
  std::vector<double> shares;
  for (double decade = 1e6; decade > 1; decade /= 10)
    for (const double factor : {1.0, 1.8, 3.2, 5.6}) shares.push_back(factor / decade);
  shares.push_back(1);
  return shares;
}

FragmentSummary summarize_fragments(const dynamics::SampleResult& result) {
  const dynamics::Fragments& found = result.fragments;
  FragmentSummary row;
  if (found.of_node.empty()) return row;
  const auto n = found.pieces.size();
  const auto mass = [&](std::size_t k) { return k < n ? found.pieces[k].mass : 0; };
  row.body_mass = found.mass;
  row.number = static_cast<double>(n);
  row.largest_mass = mass(0);
  row.second_mass = mass(1);
  row.dust_mass = found.dust.mass;
  row.fastest = row.kinetic_energy = 0;
  double sum = 0;
  std::vector<double> masses;
  for (const dynamics::Fragment& one : found.pieces) {
    sum += one.mass;
    masses.push_back(one.mass);
    row.fastest = std::max(row.fastest, norm(one.velocity));
    row.kinetic_energy += one.kinetic_of_mean();
  }
  if (n > 0) {
    row.mean_mass = sum / row.number;
    row.median_mass = quantile(masses, 0.5);
  }
  if (!result.fragment_history.empty()) {
    const dynamics::FragmentCount& last = result.fragment_history.back();
    row.frozen = static_cast<double>(last.frozen);
    row.frozen_mass = last.frozen_mass;
    row.frozen_energy = last.frozen_energy;
  }
  for (const double share : fragment_shares())
    row.heavier.push_back(static_cast<double>(
        std::ranges::count_if(masses, [&](double one) { return one >= share * found.mass; })));
  return row;
}

void measure_crossings(const geometry::Body& body, const cracks::CrackSurface& surface,
                       const input::Sections& sections, SampleSummary& row) {
  set_crossings(cracks::section_crossings(body, surface, cracks::find_branches(body, surface),
                                          cracks::planes_of(sections)),
                row);
}

std::vector<SampleSummary> gather_on_root(const parallel::Communicator& group,
                                          std::span<const SampleSummary> rows) {
  const std::vector<std::byte> mine =
      parallel::agree(group, [&] { return to_bytes(std::vector<SampleSummary>(rows.begin(), rows.end())); });
  const auto all = parallel::gather_bytes_on_root(group, mine, "the rows of all samples");

  return parallel::agree(group, [&] {
    std::vector<SampleSummary> gathered;
    Unpacker unpacker(all);
    while (!unpacker.empty()) {
      for (SampleSummary& row : unpacker.get<std::vector<SampleSummary>>())
        gathered.push_back(std::move(row));
    }
    return gathered;
  });
}

std::vector<std::string> ensemble_warnings(std::span<const SampleSummary> samples) {
  std::vector<std::string> warnings;
  for (auto& warning : {fast_crack_warning(samples), onset_warning(samples)})
    if (warning) warnings.push_back(*warning);
  return warnings;
}

const char* headline_load(std::span<const SampleSummary> samples) {
  const auto has = [&](double SampleSummary::*load) {
    return std::ranges::any_of(samples, [load](const SampleSummary& row) {
      return row.status == SampleStatus::done && !std::isnan(row.*load);
    });
  };
  if (std::ranges::any_of(samples, has_late_onset)) return "peak_load";
  return has(&SampleSummary::onset_force)        ? "onset_force"
         : has(&SampleSummary::first_break_load) ? "first_break_load"
                                                 : "peak_load";
}

}  // namespace crackle::analysis
