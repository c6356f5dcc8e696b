// SPDX-License-Identifier: GPL-3.0-or-later
// crackle check: validates an input file and estimates the cost of running it.
#include "crackle/common/failure.h"
#include "crackle/common/heartbeat.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/stopwatch.h"
#include "crackle/dynamics/load_outlook.h"
#include "crackle/dynamics/model_limits.h"
#include "crackle/dynamics/sample_run.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/cost_model.h"
#include "crackle/ensemble/estimate.h"
#include "crackle/ensemble/measured_cost.h"
#include "crackle/ensemble/memory.h"
#include "crackle/ensemble/trial.h"
#include "crackle/fracture/criterion.h"
#include "crackle/fracture/toughness.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/condition_region.h"
#include "crackle/geometry/mesh_regions.h"
#include "crackle/geometry/mesh_statistics.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/partition.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/poisson_limits.h"
#include "crackle/input/reader.h"
#include "crackle/input/softening_limits.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/parallel/agreement.h"
#include "crackle/uncertainty/random_inputs.h"

#include "commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

struct CheckOptions {
  std::string file;
  bool keys = false;
  std::int64_t ranks = 0;  ///< number of ranks to plan for; 0: no plan
  int phases = ensemble::usual_phases;
  std::int64_t samples = 0;  ///< number of samples to try; 0: sample 0 only
  bool measure = true;
};

/// Measured duration of the time loop [s].
constexpr double measured_seconds = 1;
/// Time of two static solves of a body of a million tetrahedra [s], for a notice only.
constexpr double solves_of_a_million = 60;
constexpr double short_wait = 20;  // [s]

std::string duration_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  return seconds < 7200 ? fmt::format("{:.3g} min", seconds / 60) : fmt::format("{:.3g} h", seconds / 3600);
}

std::string length_text(double length) {
  return quantity_text(length, "m");
}

std::string time_text(double time) {
  return quantity_text(time, "s");
}

/// Sample 0 and its properties.
struct Subject {
  const input::Parameters& parameters;
  const geometry::Body& body;
  geometry::Realization realization;
  double stable_step;  ///< [s]
  ensemble::PhaseWork phase;
  double rest_seconds;  ///< on one core: mesh, stable step, crack analysis and output

  double n_nodes() const { return static_cast<double>(realization.nodes.size()); }
  double n_tetrahedra() const { return static_cast<double>(realization.tetrahedra.size()); }
  int n_samples() const { return parameters.ensemble.samples; }
  /// "1 sample", "200 samples"
  std::string samples_text() const {
    return fmt::format("{} sample{}", n_samples(), n_samples() == 1 ? "" : "s");
  }
};

/// @param base receives the shared mother points
Subject make_subject(const input::Parameters& parameters, const geometry::Body& body,
                     geometry::MotherPoints& base) {
  if (parameters.mesh.base == input::Base::shared)
    base = ensemble::make_base_points(body, parameters, notify);
  const ThreadClock clock;
  Heartbeat heartbeat(notify);
  heartbeat.begin("making the mesh of sample 0");
  auto realization = ensemble::with_retries([&](std::uint64_t sample, int attempt) {
    return ensemble::make_sample_mesh(body, base, parameters, sample, attempt);
  })(0);
  const double stable_step = dynamics::stable_step(parameters, realization);
  const auto phase = ensemble::phase_work(parameters, stable_step);
  const double analysis = static_cast<double>(realization.tetrahedra.size()) /
                          ensemble::Machine(parameters.time).root_updates_per_second;
  return {parameters, body, std::move(realization), stable_step, phase, clock.seconds() + analysis};
}

double forces_per_step(const ensemble::PhaseWork& phase) {
  return static_cast<double>(phase.force_evaluations) / static_cast<double>(phase.grid.n_steps);
}

/// Recommends the number of ranks per sample, by the cost model.
std::string plan_text(const Subject& subject, const ensemble::MeasuredCost& measured,
                      const ensemble::SampleWork& work, const ensemble::SampleCost& cost, double rate,
                      std::int64_t n_ranks) {
  const double forces = measured.outlook.breaks
                            ? work.full_durations * static_cast<double>(subject.phase.force_evaluations)
                            : 0;
  const auto plans = ensemble::make_plans(subject.realization, subject.parameters, forces, cost.quasi_static,
                                          ensemble::Machine(rate), n_ranks, subject.n_samples());
  std::string text = fmt::format(
      "\nPlans for {} rank{} and {} (jobs/clusters.md has the model):\n"
      "{:>16} {:>8} {:>16} {:>12} {:>13} {:>8} {:>9} {:>9} {:>10}\n",
      n_ranks, n_ranks == 1 ? "" : "s", subject.samples_text(), "ranks per sample", "groups",
      "tetrahedra/rank", "ghosts/rank", "time per step", "exchange", "sample", "ensemble", "efficiency");
  for (const auto& plan : plans) {
    const double step = forces_per_step(subject.phase) * plan.force.total();
    text += fmt::format("{:>16} {:>8} {:>16} {:>12} {:>10.3f} ms {:>6.1f} % {:>9} {:>9} {:>8.0f} %{}\n",
                        plan.work.ranks, plan.groups, plan.work.tetrahedra, plan.work.ghosts, 1e3 * step,
                        100 * (plan.force.exchange + plan.force.polls) / plan.force.total(),
                        duration_text(plan.sample_seconds), duration_text(plan.wall_seconds),
                        100 * plan.efficiency, plan.waits_for_master ? "  groups wait for meshes" : "");
  }
  const auto& best = ensemble::recommended(plans);
  text += fmt::format("recommended: ensemble.ranks_per_sample = {}\n", best.work.ranks);
  if (best.waits_for_master)
    text += "One master makes meshes too slowly for so many groups: set ensemble.meshes = \"auto\".\n";
  return text;
}

using Rows = std::vector<input::Line>;

/// Lists the refined regions of the mesh and their contents.
void add_regions(Rows& rows, const Subject& subject) {
  const auto& mesh = subject.parameters.mesh;
  if (mesh.regions.empty()) return;
  const auto contents = geometry::region_contents(subject.realization, subject.body, mesh);
  for (std::size_t i = 0; i < contents.size(); ++i) {
    const bool is_rest = i == mesh.regions.size();
    const char* const rest = subject.parameters.specimen.notches.empty() ? "rest" : "notches and rest";
    rows.emplace_back(is_rest ? rest : fmt::format("mesh.region[{}]", i),
                      fmt::format("{} nodes, {} tetrahedra{}", contents[i].nodes, contents[i].tetrahedra,
                                  is_rest ? "" : " at " + length_text(mesh.regions[i].spacing)));
  }
}

/// Describes the approximation of a circle or an ellipse by chords.
void add_curve(Rows& rows, const plane::Shape& shape, const std::string& name, const plane::Point& centre,
               const plane::Point& semi_axes, double angle) {
  const plane::Point along{std::cos(angle), std::sin(angle)};
  int n_chords = 0;
  double longest = 0;
  double least_radius = 1;  // smallest distance of a chord's midpoint from the centre, relative to the curve
  double area = 0;
  for (const plane::Loop& loop : shape.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      if (shape.parts[static_cast<std::size_t>(loop.part[i])].name != name) continue;
      const auto from_centre = [&](const plane::Point& p) { return plane::operator-(p, centre); };
      const plane::Point from = from_centre(loop.from(i));
      const plane::Point to = from_centre(loop.to(i));
      const plane::Point middle{(from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
      ++n_chords;
      longest = std::max(longest, plane::norm(plane::operator-(to, from)));
      least_radius = std::min(least_radius, plane::norm({plane::dot(middle, along) / semi_axes[0],
                                                         plane::cross(along, middle) / semi_axes[1]}));
      area += plane::cross(from, to) / 2;
    }
  if (n_chords == 0) return;
  const double exact = std::numbers::pi * semi_axes[0] * semi_axes[1];
  rows.emplace_back(name, fmt::format("{} chords of up to {}, up to {:.2g} % of the radius inside the curve",
                                      n_chords, length_text(longest), 100 * (1 - least_radius)));
  // If a curve is cut by something else, only part of it is left.
  if (std::abs(area) > exact / 2)
    rows.back().second += fmt::format(", area {:+.2g} %", 100 * (std::abs(area) / exact - 1));
}

void add_curves(Rows& rows, const input::Specimen& specimen) {
  if (!specimen.shape) return;
  if (specimen.outline && specimen.outline->polygon.empty()) {
    const double radius = specimen.outline->radius;
    add_curve(rows, *specimen.shape, "edge-0", {radius, radius}, {radius, radius}, 0);
  }
  for (std::size_t i = 0; i < specimen.holes.size(); ++i)
    if (const input::Hole& hole = specimen.holes[i]; hole.polygon.empty())
      add_curve(rows, *specimen.shape, fmt::format("hole-{}", i), hole.center, hole.semi_axes, hole.angle);
}

/// Ratio of largest to smallest toughness above which the mesh, not the material, decides where cracks run
/// fast.
constexpr double uneven_toughness = 4.0 / 3;

/// A warning if a uniform strength makes the toughness vary along the crack paths; otherwise empty.
std::string uneven_toughness_text(const Subject& subject) {
  const auto& parameters = subject.parameters;
  // The spacings of points from a file are not known.
  if (parameters.fracture.toughness > 0 || parameters.fracture.length > 0 || parameters.mesh.points)
    return {};
  const auto criterion =
      fracture::make_criterion(parameters, {parameters.fracture.strength}, subject.phase.grid.step);
  const auto range = fracture::toughness_along_ligaments(parameters, subject.body, criterion->strength(0));
  if (!range || range->greatest <= uneven_toughness * range->least) return {};
  return fmt::format(
      "\nWarning: with one strength the toughness follows the spacing, {:.3g} to {:.3g} J/m^2 along the "
      "ligaments; make the spacing even there with [[mesh.region]], or give fracture.toughness instead of "
      "fracture.strength\n",
      range->least, range->greatest);
}

/// Along the ligaments, or anywhere in a body without notches [m].
fracture::Range crack_spacing(const Subject& subject) {
  const auto& mesh = subject.parameters.mesh;
  return fracture::spacing_along_ligaments(subject.parameters, subject.body)
      .value_or(fracture::Range{geometry::SpacingField(subject.body, mesh).lower_bound(subject.body.bounds()),
                                mesh.spacing});
}

/// Minimum spacings per radius of the averaging ball; below it results depend on the mesh.
constexpr double resolving_spacings = 1.5;

/// Lists conditions whose regions require a finer mesh than the rest of the input.
std::string refining_regions_text(const input::Parameters& parameters) {
  std::string text;
  for (const geometry::RegionRefinement& one : geometry::region_refinements(parameters))
    text += fmt::format("\nThe region of boundary[{}] makes the mesh as fine as {} there.\n", one.condition,
                        length_text(one.spacing));
  return text;
}

/// A warning if the mesh does not resolve the averaging ball; otherwise empty.
std::string unresolved_length_text(const Subject& subject) {
  const auto& parameters = subject.parameters;
  const double length = parameters.fracture.length;
  if (length == 0 || parameters.mesh.points) return {};
  const double greatest = crack_spacing(subject).greatest;
  if (resolving_spacings * greatest <= length) return {};
  return fmt::format(
      "\nWarning: the averaging length of {} is less than {:.2g} times the greatest spacing where cracks "
      "run, "
      "{}, so results depend on the mesh there; make it at most {} with [[mesh.region]]\n",
      length_text(length), resolving_spacings, length_text(greatest),
      length_text(length / resolving_spacings));
}

/// A warning if the mesh does not resolve the process zone of softening; otherwise empty.
std::string unresolved_softening_text(const Subject& subject) {
  const auto& parameters = subject.parameters;
  if (parameters.fracture.release != input::Release::softening || parameters.mesh.points) return {};
  const double greatest = crack_spacing(subject).greatest;
  const double admissible = input::resolving_share * input::process_zone_length(parameters);
  if (greatest <= admissible) return {};
  const double snap_back = input::snap_back_spacing(parameters);
  return fmt::format(
      "\nWarning: where cracks run spacings go up to {}, and softening wants at most {}{}; refine with "
      "[[mesh.region]]\n",
      length_text(greatest), length_text(admissible),
      greatest < snap_back
          ? std::string()
          : fmt::format("; from {} on tetrahedra break at once, with more energy than the toughness",
                        length_text(snap_back)));
}

/// Minimum spacings per correlation length; below it neighbouring tetrahedra differ strongly.
constexpr double resolved_spacings = 2;

/// A warning if the material's variation makes results mesh-dependent; otherwise empty.
std::string unresolved_variation_text(const Subject& subject) {
  const auto& variation = subject.parameters.fracture.variation;
  if (!variation) return {};
  const double length = variation->correlation_length;
  if (length == 0)
    return "\nWarning: each tetrahedron has a strength of its own, so only the load at the first break of a "
           "smoothly stressed body does not depend on the spacing; give "
           "fracture.variation.correlation_length, "
           "of several spacings, for cracks\n";
  const double finest =
      geometry::SpacingField(subject.body, subject.parameters.mesh).lower_bound(subject.body.bounds());
  if (length >= resolved_spacings * finest) return {};
  return fmt::format(
      "\nWarning: the correlation length of {} is less than {:.0f} spacings of {}, so results depend on the "
      "spacing; give a longer one, or a finer mesh\n",
      length_text(length), resolved_spacings, length_text(finest));
}

/// The criterion on this mesh: strength and toughness are related by the local spacing.
void add_criterion(Rows& rows, const Subject& subject) {
  const auto& parameters = subject.parameters;
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain =
      geometry::split(subject.realization, geometry::partition(subject.realization, 1)).front();
  const auto operators = mechanics::make_operators(subdomain, parameters.material.density);
  const auto criterion = fracture::make_criterion(
      parameters, fracture::tetrahedron_strengths(self, parameters, 0, subdomain, operators),
      subject.phase.grid.step);
  const auto strengths = criterion->strengths();
  const auto spread = [](std::vector<double> values, double unit, const char* name) {
    const auto q = geometry::quantiles(std::move(values));
    return fmt::format("least {:.4g}, median {:.4g}, greatest {:.4g} {}", q.smallest / unit, q.median / unit,
                       q.largest / unit, name);
  };
  const char* const varied = parameters.fracture.variation ? ", with the variation of sample 0" : "";
  if (parameters.fracture.release == input::Release::softening) {
    const double length = input::process_zone_length(parameters);
    const auto spacing = crack_spacing(subject);
    rows.emplace_back("process zone",
                      fmt::format("{}, E G / strength^2: {:.3g} to {:.3g} spacings where cracks run",
                                  length_text(length), length / spacing.greatest, length / spacing.least));
    if (parameters.fracture.variation)
      rows.emplace_back("strength", spread({strengths.begin(), strengths.end()}, 1e6, "MPa") +
                                        ", from the variation of sample 0");
    return;
  }
  const char* const from = parameters.fracture.length > 0 ? "the averaging length" : "the local spacing";
  if (parameters.fracture.toughness > 0) {
    rows.emplace_back("strength", spread({strengths.begin(), strengths.end()}, 1e6, "MPa") +
                                      fmt::format(", from the toughness and {}{}", from, varied));
    return;
  }
  if (parameters.fracture.variation)
    rows.emplace_back("strength", spread({strengths.begin(), strengths.end()}, 1e6, "MPa") +
                                      ", from the variation of sample 0");
  if (parameters.fracture.memory == input::Memory::step)
    rows.emplace_back("strength",
                      fmt::format("{:.4g} MPa, which breaks in one step", criterion->strength(0) / 1e6));
  auto toughness = fracture::fracture_spacings(self, parameters, subdomain, operators);
  for (std::size_t t = 0; t < toughness.size(); ++t)
    toughness[t] = fracture::toughness_of(parameters, strengths[t], toughness[t]);
  rows.emplace_back("toughness", spread(std::move(toughness), 1, "J/m^2") +
                                     fmt::format(", from the strength and {}{}", from, varied));
}

void add_waves(Rows& rows, const input::Parameters& parameters) {
  const auto& material = parameters.material;
  const double dilatational = mechanics::dilatational_speed(material);
  const double shear = mechanics::shear_speed(material);
  rows.emplace_back("wave speeds", fmt::format("c_d {:.4g} m/s, c_s {:.4g} m/s, c_R {:.4g} m/s", dilatational,
                                               shear, mechanics::rayleigh_speed(material)));
  rows.emplace_back("transit times",
                    fmt::format("{} along the length (dilatational), {} across the width (shear)",
                                time_text(parameters.specimen.size[2] / dilatational),
                                time_text(parameters.specimen.size[1] / shear)));
  rows.emplace_back("arrest window",
                    parameters.time.start != input::Start::rest
                        ? time_text(dynamics::arrest_window(parameters)) + " without a break"
                        : "none: with start = \"rest\" the phase lasts for the whole duration");
}

/// All quantities of sample 0 that need no measurement.
Rows subject_rows(const Subject& subject, double memory, double available) {
  const auto& parameters = subject.parameters;
  const int n_ranks = parameters.ensemble.ranks_per_sample;
  const double file = ensemble::sample_file_size(parameters, subject.n_nodes(), subject.n_tetrahedra());
  const double all = subject.n_samples() * file + ensemble::ensemble_file_size(parameters, subject.n_nodes());
  Rows rows{
      {"nodes", fmt::format("{}", subject.realization.nodes.size())},
      {"tetrahedra", fmt::format("{} (worst quality {:.3f})", subject.realization.tetrahedra.size(),
                                 subject.realization.report.min_quality)},
      {"boundary triangles", fmt::format("{}", subject.realization.boundary.size())},
  };
  add_curves(rows, subject.parameters.specimen);
  add_regions(rows, subject);
  add_criterion(rows, subject);
  add_waves(rows, parameters);
  rows.insert(rows.end(),
              {{"stable step", time_text(subject.stable_step)},
               {"time step", time_text(subject.phase.grid.step)},
               {"steps", fmt::format("{} per dynamic phase", subject.phase.grid.n_steps)},
               {"force evaluations", fmt::format("{} per dynamic phase", subject.phase.force_evaluations)},
               {"memory", fmt::format("{:.0f} MB per sample, on {} rank{}; {:.3g} GB are available here",
                                      memory / 1e6, n_ranks, n_ranks == 1 ? "" : "s", available / 1e9)},
               {"output", fmt::format("{:.3g} MB per sample, {:.3g} MB for {}", file / 1e6, all / 1e6,
                                      subject.samples_text())}});
  return rows;
}

std::string phases_text(int n) {
  return fmt::format("{} dynamic phase{}", n, n == 1 ? "" : "s");
}

/// The load and time of the first break in equilibrium, up to which the loading rate has no effect; empty if
/// the loads break nothing.
std::string loading_text(const dynamics::LoadOutlook& outlook) {
  if (!std::isfinite(outlook.time)) return {};
  return fmt::format(
      "in equilibrium up to the first break ({}, after {}); until then the loading rate has no effect",
      quantity_text(outlook.load, "N"), time_text(outlook.time));
}

/// Core-hours above which a slip in the input is likely [h].
constexpr double unaffordable_hours = 10'000;

std::string unaffordable_text(const Subject& subject, double hours) {
  if (hours < unaffordable_hours) return {};
  const geometry::SpacingField spacing(subject.body, subject.parameters.mesh);
  return fmt::format(
      "{:.3g} core-hours, with {:.3g} time steps of {:.3g} tetrahedra in each dynamic phase: are "
      "time.duration = {} and a spacing down to {} intended?",
      hours, static_cast<double>(subject.phase.grid.n_steps), subject.n_tetrahedra(),
      time_text(subject.parameters.time.duration), length_text(spacing.lower_bound(subject.body.bounds())));
}

std::string cost_text(const Subject& subject, const CheckOptions& options) {
  const auto& parameters = subject.parameters;
  const auto measured = ensemble::measure_cost(parameters, subject.realization, measured_seconds);
  const auto work = ensemble::sample_work(parameters, options.phases);
  const auto cost = ensemble::sample_cost(measured, subject.phase, work, subject.rest_seconds);
  const double rate = forces_per_step(subject.phase) * subject.n_tetrahedra() / measured.step;
  const bool breaks = measured.outlook.breaks;
  const int n_phases = breaks ? work.phases : 0;
  Rows rows{
      {"dynamic phase",
       fmt::format("{:.3g} s for the full duration: {:.3g} ms per step, {:.3g} million tetrahedron updates "
                   "per second",
                   cost.phase, 1e3 * measured.step, rate / 1e6)}};
  if (parameters.time.start != input::Start::rest) {
    std::string solves =
        fmt::format("{:.3g} s: {:.3g} s for the first equilibrium", cost.quasi_static, measured.first_solve);
    if (breaks)
      solves +=
          fmt::format(", {:.3g} s for each of {} after breaks and arrests", measured.next_solve, work.solves);
    rows.emplace_back("quasi-static part", solves);
    if (parameters.time.start == input::Start::quasi_static)
      if (std::string loading = loading_text(measured.outlook); !loading.empty())
        rows.emplace_back("loading", std::move(loading));
  }
  rows.emplace_back("sample", fmt::format("{:.3g} s with {}{}", cost.total(), phases_text(n_phases),
                                          n_phases > 1 ? fmt::format(", of which {} arrest{}", n_phases - 1,
                                                                     n_phases == 2 ? "s" : "")
                                          : n_phases == 0 ? ": no load of the program breaks the body"
                                                          : ""));
  const double hours = subject.n_samples() * cost.total() / 3600;
  rows.emplace_back("core-hours", fmt::format("{:.3g} for {}, with {} each", hours, subject.samples_text(),
                                              phases_text(n_phases)));
  std::string text = input::aligned(rows);
  for (const std::string& warning :
       {dynamics::weak_load_warning(parameters, measured.outlook),
        dynamics::fast_loading_warning(parameters, measured.outlook.time), unaffordable_text(subject, hours)})
    if (!warning.empty()) text += fmt::format("\nWarning: {}\n", warning);
  if (options.ranks > 0) text += plan_text(subject, measured, work, cost, rate, options.ranks);
  return text;
}

/// Tries samples as a run would.
/// @param first the mesh of sample 0 if available; or nullptr
/// @return reasons of failures, each with its sample number; empty if there are none
std::vector<std::string> try_samples(const input::Parameters& parameters, const geometry::Body& body,
                                     const geometry::MotherPoints& base, const geometry::Realization* first,
                                     const CheckOptions& options) {
  Heartbeat heartbeat(notify);
  ensemble::Trial trial(parameters, body, base,
                        options.measure ? ensemble::TrialDepth::start : ensemble::TrialDepth::setup);
  const auto n = std::clamp<std::int64_t>(options.samples, 1, parameters.ensemble.samples);
  std::vector<std::string> failures;
  for (std::int64_t i = 0; i < n; ++i) {
    heartbeat.begin(n == 1 ? "starting sample 0"
                           : fmt::format("starting sample {} ({} of {}); {} would fail so far", i, i + 1, n,
                                         failures.size()));
    const bool is_made = i == 0 && first != nullptr && parameters.random.empty();
    const std::string failure = is_made ? trial.failure({.sample = 0, .realization = *first, .error = {}})
                                        : trial.failure(static_cast<std::uint64_t>(i));
    if (!failure.empty()) failures.push_back(fmt::format("sample {} would fail: {}", i, failure));
  }
  if (options.samples > 0)
    fmt::print("\nOf {} sample{}, {} would fail.\n", n, n == 1 ? "" : "s", failures.size());
  return failures;
}

/// @throws std::runtime_error with all failures, if any
void refuse(const std::vector<std::string>& failures) {
  if (failures.empty()) return;
  fail("{}", fmt::join(failures, "\n"));
}

/// Prints what is known of sample 0 without computing it.
void print_subject(const Subject& subject, double memory, const ensemble::AvailableMemory& available) {
  const auto& parameters = subject.parameters;
  fmt::print("{}{}", input::aligned(subject_rows(subject, memory, available.bytes)),
             refining_regions_text(parameters) + uneven_toughness_text(subject) +
                 unresolved_length_text(subject) + unresolved_softening_text(subject) +
                 unresolved_variation_text(subject));
  for (const auto& warning : dynamics::model_warnings(parameters, subject.body))
    fmt::print("\nWarning: {}\n", warning);
  const int n_ranks = parameters.ensemble.ranks_per_sample;
  const std::string whose = n_ranks == 1 ? "a sample" : fmt::format("the {} ranks of a sample", n_ranks);
  if (const auto message = ensemble::shortage(memory, whose, available))
    fmt::print(
        "\nWarning: not to be computed here: {}; elsewhere, or with coarser spacings, more nodes, or more "
        "ranks_per_sample\n",
        *message);
  std::fflush(stdout);
}

/// Time of two static solves, for a notice only [s].
double solving_seconds(const Subject& subject) {
  return solves_of_a_million * std::pow(subject.n_tetrahedra() / 1e6, 4.0 / 3);
}

/// Measures the cost of sample 0 on this machine.
/// @throws std::runtime_error with the reason if it will fail
void print_cost(const Subject& subject, const CheckOptions& options) {
  const auto& parameters = subject.parameters;
  const bool solves = parameters.time.start != input::Start::rest;
  const double wait = solves ? solving_seconds(subject) : 0;
  fmt::print("\nTime of one core of this machine, from {}{:.2g} s of the time loop{}:\n",
             solves ? "two static solves and " : "", measured_seconds,
             wait > short_wait ? fmt::format(", which takes about {} to measure", duration_text(wait)) : "");
  std::fflush(stdout);
  Heartbeat heartbeat(notify);
  heartbeat.begin("measuring the cost");
  try {
    fmt::print("{}", cost_text(subject, options));
  } catch (const ensemble::NotMeasured& error) {
    fmt::print("not measured: {}\n", error.what());
  } catch (const std::runtime_error& error) {
    // No sample uses the input's own values of random quantities.
    if (subject.parameters.random.empty()) throw;
    fmt::print("not measured, with the input's own values: {}\n", error.what());
  }
}

/// Warns if loads from rest are far from breaking the body.
void print_rest_outlook(const Subject& subject) {
  const auto& parameters = subject.parameters;
  if (parameters.time.start != input::Start::rest || solving_seconds(subject) > short_wait) return;
  Heartbeat heartbeat(notify);
  heartbeat.begin("solving for the equilibrium");
  try {
    const auto outlook = dynamics::static_outlook(parameters, subject.realization);
    if (const auto warning = dynamics::weak_load_warning(parameters, outlook); !warning.empty())
      fmt::print("\nWarning: {}\n", warning);
  } catch (const std::runtime_error&) {
    // A sample that starts from rest needs no equilibrium.
  }
}

/// Why one core cannot measure a sample here; empty if it can.
std::optional<std::string> measuring_shortage(const Subject& subject,
                                              const ensemble::AvailableMemory& available) {
  input::Parameters measured = subject.parameters;
  measured.output.frames = 0;  // no frames are stored
  const double needed =
      ensemble::memory_demand(measured, subject.n_nodes(), subject.n_tetrahedra(), ensemble::one_group(1))
          .root;
  return ensemble::shortage(needed, "measuring the cost", available);
}

/// Checks the memory for the mesh only; the machine that computes the samples may have more memory, or more
/// nodes.
/// @throws std::runtime_error when there is too little
void check_mesh_memory(const input::Parameters& parameters, const geometry::Body& body,
                       const ensemble::AvailableMemory& available) {
  if (const auto message =
          ensemble::shortage(ensemble::expected_mesh_memory(parameters, body), "making the mesh", available))
    throw std::runtime_error(*message + "; use coarser spacings, or check the input where there is more");
}

/// Prints each part as soon as it is known.
/// @return reasons why samples would fail
std::vector<std::string> print_estimate(const input::Parameters& parameters, const CheckOptions& options) {
  const auto body = geometry::make_body(parameters);
  const auto available = ensemble::available_memory();
  check_mesh_memory(parameters, *body, available);
  geometry::MotherPoints base;
  const Subject subject = make_subject(parameters, *body, base);
  const int n_ranks = parameters.ensemble.ranks_per_sample;
  const auto demand = ensemble::memory_demand(parameters, subject.n_nodes(), subject.n_tetrahedra(),
                                              ensemble::one_group(n_ranks));
  const double memory = demand.master + (n_ranks - 1) * demand.member;  // of all ranks that share a sample
  print_subject(subject, memory, available);
  const auto shortage = measuring_shortage(subject, available);
  if (shortage) fmt::print("\nNo sample was tried and the cost was not measured: {}\n", *shortage);
  const auto failures = shortage ? std::vector<std::string>()
                                 : try_samples(parameters, *body, base, &subject.realization, options);
  if (!shortage && options.measure) {
    print_rest_outlook(subject);
    if (failures.empty()) print_cost(subject, options);
  }
  return failures;
}

/// Tries samples of a case of a sweep.
/// @return reasons why they would fail
std::vector<std::string> try_case(const input::Parameters& parameters, const CheckOptions& options) {
  try {
    const auto body = geometry::make_body(parameters);
    check_mesh_memory(parameters, *body, ensemble::available_memory());
    geometry::MotherPoints base;
    if (parameters.mesh.base == input::Base::shared)
      base = ensemble::make_base_points(*body, parameters, notify);
    return try_samples(parameters, *body, base, nullptr, options);
  } catch (const std::runtime_error& error) {
    return {error.what()};
  }
}

/// Prints the cases after the first, whose warnings are known already.
/// @return reasons why their samples would fail, if these are to be tried
std::vector<std::string> print_other_cases(const std::vector<input::Case>& cases,
                                           const CheckOptions& options) {
  const auto warnings_of = [](const input::Case& one) {
    return dynamics::model_warnings(one.parameters, *geometry::make_body(one.parameters));
  };
  std::vector<std::string> failures;
  std::vector<std::string> known;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (const std::string& warning : warnings_of(cases[i])) {
      if (std::ranges::find(known, warning) != known.end()) continue;
      known.push_back(warning);
      if (i > 0) fmt::print("\nWarning: case {}: {}\n", i, warning);
    }
    if (i == 0 || options.samples == 0) continue;
    fmt::print("\nCase {}: {}", i, to_string(cases[i].settings));
    for (const std::string& failure : try_case(cases[i].parameters, options))
      failures.push_back(fmt::format("case {}: {}", i, failure));
  }
  return failures;
}

/// Prints quantiles of each random input, and the number of draws that make an invalid input.
void print_random_inputs(const input::Parameters& parameters) {
  const auto& random = parameters.random;
  if (random.empty()) return;
  const auto& ensemble = parameters.ensemble;
  Rows rows;
  for (const input::RandomInput& one : random)
    rows.emplace_back(one.key, fmt::format("{}: 90 % from {} to {}, median {}", input::describe(one),
                                           format_value(one, uncertainty::quantile(one, 0.05)),
                                           format_value(one, uncertainty::quantile(one, 0.95)),
                                           format_value(one, uncertainty::quantile(one, 0.5))));
  fmt::print("Random inputs, {} draws ({}) on {} mesh{} each:\n{}", ensemble.n_inputs(),
             input::plan_names[static_cast<std::size_t>(ensemble.plan)], ensemble.replicates,
             ensemble.replicates == 1 ? "" : "es", input::aligned(rows));
  constexpr std::uint64_t most_tried = 1000;
  const std::uint64_t n_tried = std::min(ensemble.n_inputs(), most_tried);
  std::uint64_t n_bad = 0;
  std::string first;
  for (std::uint64_t i = 0; i < n_tried; ++i) {
    try {
      uncertainty::sample_parameters(parameters, i * static_cast<std::uint64_t>(ensemble.replicates));
    } catch (const std::runtime_error& error) {
      if (n_bad++ == 0) first = error.what();
    }
  }
  if (n_bad > 0) fmt::print("\nWarning: {} of {} draws will fail; the first: {}\n", n_bad, n_tried, first);
  fmt::print("\n");
}

/// One line for each case of a sweep.
void print_cases(const std::vector<input::Case>& cases) {
  if (cases.empty()) return;
  fmt::print("{} cases:\n", cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) fmt::print("{:>4}  {}\n", i, to_string(cases[i].settings));
  for (const std::string& warning : input::sweep_warnings(cases)) fmt::print("\nWarning: {}\n", warning);
  fmt::print("\n");
}

int check(const parallel::Communicator& world, const CheckOptions& options) {
  const std::string& file = options.file;
  const input::Parameters parameters = read_input(world, file);
  std::vector<input::Case> cases;
  if (!parameters.sweeps.empty()) cases = read_cases(world, parameters, file);
  parallel::agree(world, [&] {
    if (!world.is_root()) return;
    if (parameters.mesh.points)
      geometry::read_points(*parameters.mesh.points, *geometry::make_body(parameters));
    const std::string notice = input::bits_notice(parameters.time.engine);
    fmt::print("{}\n\n{}{}{}\n", file, input::echo(parameters), notice, notice.empty() ? "" : "\n");
    print_random_inputs(parameters);
    print_cases(cases);
    fmt::print("The mesh of sample 0{} and what the ensemble{} takes:\n",
               parameters.random.empty() ? "" : ", with the input's own values,",
               cases.empty() ? "" : " of the first case");
    std::fflush(stdout);
    try {
      auto failures = print_estimate(cases.empty() ? parameters : cases.front().parameters, options);
      const auto others = print_other_cases(cases, options);
      failures.insert(failures.end(), others.begin(), others.end());
      refuse(failures);
    } catch (const std::runtime_error& error) {
      fail("{}: {}", file, error.what());
    }
    fmt::print("\n{} is valid\n", file);
  });
  return success;
}

}  // namespace

void add_check_command(CLI::App& app, Action& run) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand(
      "check", "Validate an input file; print the resolved values and what running them will take");
  command->add_option("input", options->file, "input file (TOML)");
  command->add_flag("--keys", options->keys, "print the list of all input keys (Markdown) instead");
  CLI::Option* const ranks =
      command
          ->add_option("--ranks", options->ranks,
                       "plan for this many ranks: how many should share a sample, and how long it takes")
          ->check(CLI::Range(1, 10'000'000));
  command
      ->add_option(
          "--phases", options->phases,
          "dynamic phases that a sample is taken to need before its cracks do not arrest any more, the "
          "last one included")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option(
          "--samples", options->samples,
          "start this many samples, of each case of a sweep, as run would, and say how many would fail")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_flag("!--no-measure", options->measure,
                 "do not measure what a sample costs on this machine, and solve for no equilibrium")
      ->excludes(ranks);
  command->callback([options, &run] {
    if (options->keys != options->file.empty()) {
      throw CLI::ValidationError("check takes either an input file or --keys");
    }
    run = [options](const parallel::Communicator& world) {
      if (!options->keys) return check(world, *options);
      if (world.is_root()) fmt::print("{}", input::key_list());
      return static_cast<int>(success);
    };
  });
}

}  // namespace crackle::apps
