// SPDX-License-Identifier: GPL-3.0-or-later
#include "check.h"

#include "analysis/sample_summary.h"
#include "common/heartbeat.h"
#include "common/quantity_text.h"
#include "common/real.h"
#include "common/stopwatch.h"
#include "common/text_table.h"
#include "dynamics/resolution.h"
#include "dynamics/sample_run.h"
#include "dynamics/stable_step.h"
#include "ensemble/base_points.h"
#include "fracture/fracture_law.h"
#include "fracture/material_field.h"
#include "fracture/release_time.h"
#include "fracture/toughness.h"
#include "geometry/condition_region.h"
#include "geometry/mesh_regions.h"
#include "geometry/mesh_statistics.h"
#include "geometry/partition.h"
#include "geometry/pre_crack.h"
#include "input/reader.h"
#include "input/softening_limits.h"
#include "mechanics/elasticity.h"
#include "plane/shape.h"

#include "commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

using Rows = std::vector<NamedValue>;

/// Lists the refined regions of the mesh and their contents.
void add_regions(Rows& rows, const FirstSample& subject) {
  const auto& mesh = subject.parameters.mesh;
  if (mesh.regions.empty()) return;
  const auto contents = geometry::region_contents(subject.realization, subject.body, mesh);
  for (std::size_t i = 0; i < contents.size(); ++i) {
    const bool is_rest = i == mesh.regions.size();
    const char* const rest = subject.parameters.specimen.notches.empty() ? "rest" : "notches and rest";
    rows.emplace_back(is_rest ? rest : fmt::format("mesh.region[{}]", i),
                      fmt::format("{} nodes, {} tetrahedra{}", contents[i].nodes, contents[i].tetrahedra,
                                  is_rest ? "" : " at " + quantity_text(mesh.regions[i].spacing, "m")));
  }
}

/// Describes the approximation of a circle or an ellipse by chords.
void add_curve(Rows& rows, const plane::Shape& shape, const std::string& name, const plane::Point& centre,
               const plane::Point& semi_axes, double angle) {
  const auto chords = plane::chord_approximation(shape, name, centre, semi_axes, angle);
  if (chords.n_chords == 0) return;
  rows.emplace_back(name,
                    fmt::format("{} chords of up to {}, up to {:.2g} % of the radius inside the curve",
                                chords.n_chords, quantity_text(chords.longest, "m"), 100 * chords.inside));
  // If a curve is cut by something else, only part of it is left.
  if (chords.area > 0.5) rows.back().second += fmt::format(", area {:+.2g} %", 100 * (chords.area - 1));
}

void add_curves(Rows& rows, const plane::Specimen& specimen) {
  for (std::size_t i = 0; i < specimen.regions.size(); ++i) {
    const plane::MaterialRegion& region = specimen.regions[i];
    if (!region.shape || !region.shape->polygon.empty()) continue;
    const std::string name = fmt::format("specimen.region[{}]", i);
    const plane::Loop loop{region.outline, std::vector<int>(region.outline.size(), 0)};
    add_curve(rows, {{loop}, {{name, true}}}, name, region.shape->center, region.shape->semi_axes,
              region.shape->angle);
  }
  if (!specimen.shape) return;
  if (specimen.outline && specimen.outline->polygon.empty()) {
    const double radius = specimen.outline->radius;
    add_curve(rows, *specimen.shape, "edge-0", {radius, radius}, {radius, radius}, 0);
  }
  for (std::size_t i = 0; i < specimen.holes.size(); ++i)
    if (const plane::Hole& hole = specimen.holes[i]; hole.polygon.empty())
      add_curve(rows, *specimen.shape, fmt::format("hole-{}", i), hole.center, hole.semi_axes, hole.angle);
}

/// "min 1, median 2, max 3 us"
std::string spread(std::vector<double> values, double unit, const char* name) {
  const auto q = geometry::quantiles(std::move(values));
  return fmt::format("min {:.4g}, median {:.4g}, max {:.4g} {}", q.smallest / unit, q.median / unit,
                     q.largest / unit, name);
}

/// The criterion on this mesh: strength and toughness are related by the local spacing.
void add_criterion(Rows& rows, const FirstSample& subject, const fracture::BreakableBody& body,
                   const fracture::FractureLaw& law) {
  const auto& parameters = subject.parameters;
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto strengths = law.strengths();
  const auto growth = law.growth_strengths();
  const char* const varied = parameters.fracture.variation ? ", with the variation of sample 0" : "";
  if (parameters.fracture.softens()) {
    const double length = input::process_zone_length(parameters);
    const auto spacing = dynamics::crack_spacing(parameters.mesh, subject.body);
    rows.emplace_back(
        "process zone",
        fmt::format("{}, E G / strength^2: {:.3g} to {:.3g} spacings where cracks run",
                    quantity_text(length, "m"), length / spacing.greatest, length / spacing.least));
    if (parameters.fracture.variation)
      rows.emplace_back("strength", spread({strengths.begin(), strengths.end()}, 1e6, "MPa") +
                                        ", from the variation of sample 0");
    return;
  }
  const char* const from = parameters.fracture.length > 0 ? "the averaging length" : "the local spacing";
  if (parameters.fracture_of(0).separates_nucleation()) {
    const bool by_means = parameters.fracture_of(0).nucleates_by_means();
    double n_higher = 0;
    for (std::size_t t = 0; t < growth.size(); ++t) n_higher += growth[t] >= strengths[t] ? 1 : 0;
    const double share = by_means ? 0 : n_higher / static_cast<double>(growth.size());
    rows.emplace_back("strength",
                      spread({strengths.begin(), strengths.end()}, 1e6, "MPa") +
                          fmt::format(" away from cracks{}{}{}",
                                      by_means ? ", also for the mean around a corner" : "", varied,
                                      share > 0 ? fmt::format("; in {:.3g} % of the tetrahedra the strength "
                                                              "at cracks is higher and holds everywhere",
                                                              100 * share)
                                                : ""));
    rows.emplace_back("strength at cracks", spread({growth.begin(), growth.end()}, 1e6, "MPa") +
                                                fmt::format(", from the toughness and {}{}", from, varied));
    return;
  }
  if (parameters.fracture_of(0).toughness > 0) {
    rows.emplace_back("strength", spread({strengths.begin(), strengths.end()}, 1e6, "MPa") +
                                      fmt::format(", from the toughness and {}{}", from, varied));
    return;
  }
  const bool differ = std::ranges::count(strengths, strengths.front()) != std::ssize(strengths);
  const bool is_step = parameters.fracture.accumulation == input::Accumulation::step;
  if (differ)
    rows.emplace_back("strength", spread({strengths.begin(), strengths.end()}, 1e6, "MPa") + varied);
  else if (is_step)
    rows.emplace_back("strength",
                      fmt::format("{:.4g} MPa, which breaks in one step", strengths.front() / 1e6));
  rows.emplace_back("toughness",
                    spread(fracture::tetrahedron_toughness(self, parameters, body, strengths), 1, "J/m^2") +
                        fmt::format(", from the strength and {}{}", from, varied));
}

/// How breaking tetrahedra lose their stiffness, where that follows from a speed.
/// @param crack_speed for which release speeds are asked [m/s]; 0: none
void add_release(Rows& rows, const FirstSample& subject, const fracture::BreakableBody& body,
                 double crack_speed) {
  const auto& parameters = subject.parameters;
  bool is_by_speed = false;
  for (std::size_t m = 0; m < parameters.materials.size(); ++m) {
    const input::Material& material = parameters.materials[m];
    const std::string of = material.name.empty() ? "" : ", " + material.name;
    const double rayleigh = mechanics::rayleigh_speed(material);
    if (crack_speed > 0)
      rows.emplace_back(fmt::format("cracks at {}{}", quantity_text(crack_speed, "m/s"), of),
                        crack_speed < rayleigh
                            ? fmt::format("with twice G stored take release_speed = \"{:.0f} m/s\"",
                                          fracture::release_speed_for(crack_speed, rayleigh))
                            : "are faster than Rayleigh waves, which no crack is");
    const double speed = fracture::release_speed(parameters, m);
    if (speed == 0) continue;
    is_by_speed = true;
    rows.emplace_back(
        "release speed" + of,
        fmt::format("{:.4g} m/s, {:.2g} c_R; with twice G stored, cracks run at some {:.0f} m/s", speed,
                    speed / rayleigh, fracture::driven_crack_speed(speed, rayleigh)));
  }
  if (!is_by_speed) return;
  rows.emplace_back("release time",
                    spread(body.release_law().time().values(), 1e-6, "us") + ", from the local spacing");
}

void add_waves(Rows& rows, const input::Parameters& parameters, const fracture::BreakableBody& body) {
  const auto& [elasticity, density] = body.material();
  double slowest_shear = infinity;
  for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t)
    slowest_shear = std::min(slowest_shear, mechanics::shear_speed(elasticity[t], density[t]));
  const auto waves = fracture::slowest_waves(parallel::Communicator(MPI_COMM_SELF), parameters, body);
  for (const input::Material& material : parameters.materials) {
    rows.emplace_back(
        material.name.empty() ? std::string("wave speeds") : fmt::format("wave speeds, {}", material.name),
        fmt::format("c_d {:.4g} m/s, c_s {:.4g} m/s, c_R {:.4g} m/s", mechanics::dilatational_speed(material),
                    mechanics::shear_speed(material), mechanics::rayleigh_speed(material)));
  }
  if (parameters.maps_stiffness() ||
      std::ranges::any_of(parameters.materials, [](const auto& one) { return one.variation.has_value(); }))
    rows.emplace_back(
        "", fmt::format("before rasters and variations; with these, bar waves of {:.4g} m/s, "
                        "the mean of sample 0{}",
                        waves.bar, parameters.materials.size() > 1 ? ", in the slowest material" : ""));
  rows.emplace_back("transit times",
                    fmt::format("{} along the length (dilatational), {} across the width (shear)",
                                quantity_text(parameters.specimen.size[2] / waves.dilatational, "s"),
                                quantity_text(parameters.specimen.size[1] / slowest_shear, "s")));
  const input::Start start = parameters.time.start;
  rows.emplace_back(
      "arrest window",
      start == input::Start::rest
          ? "none: with start = \"rest\" the phase lasts for the whole duration"
          : quantity_text(dynamics::arrest_window(parameters.time, parameters.specimen.size, waves), "s") +
                " without a break" +
                (start == input::Start::equilibrium ? ", counted from the first break on" : ""));
}

/// The cracks of the input that open no tetrahedron.
std::vector<std::size_t> idle_pre_cracks(const FirstSample& subject) {
  std::vector<std::size_t> idle(subject.stand_in ? 0 : subject.parameters.specimen.cracks.size());
  std::iota(idle.begin(), idle.end(), std::size_t{0});
  for (const std::int32_t code : subject.realization.pre_crack)
    if (code != 0) std::erase(idle, static_cast<std::size_t>(geometry::PreCrackCut::from(code).crack));
  return idle;
}

/// Estimates of a mesh that is not made.
Rows estimated_rows(const FirstSample& subject) {
  return {
      {"nodes", fmt::format("about {:.3g}", subject.n_nodes())},
      {"tetrahedra", fmt::format("about {:.3g}", subject.n_tetrahedra())},
      {"estimated", fmt::format("from a mesh of {} tetrahedra, with {:.3g} times the spacings; --samples 1 "
                                "makes the input's own mesh and starts sample 0",
                                subject.realization.tetrahedra.size(), subject.stand_in->refinement)}};
}

/// The mesh, and what follows from it.
/// @param crack_speed as in print_subject
Rows mesh_rows(const FirstSample& subject, double crack_speed) {
  const auto& parameters = subject.parameters;
  Rows rows{
      {"nodes", fmt::format("{}", subject.realization.nodes.size())},
      {"tetrahedra", fmt::format("{} (worst quality {:.3f})", subject.realization.tetrahedra.size(),
                                 subject.realization.report.min_quality)},
      {"boundary triangles", fmt::format("{}", subject.realization.boundary.size())},
  };
  if (const auto& opened = subject.realization.pre_crack; !opened.empty())
    rows.emplace_back("pre-cracks",
                      fmt::format("open {} tetrahedra",
                                  opened.size() - static_cast<std::size_t>(std::ranges::count(opened, 0))));
  add_curves(rows, subject.parameters.specimen);
  for (auto& row : face_rows(subject.parameters.specimen)) rows.push_back(std::move(row));
  for (auto& row : material_rows(parameters, subject.realization)) rows.push_back(std::move(row));
  add_regions(rows, subject);
  const auto subdomain =
      geometry::split(subject.realization, geometry::partition(subject.realization, 1)).front();
  fracture::BreakableBody body(subdomain,
                               fracture::make_material_field(parameters, 0, fracture::span_of(subdomain)));
  const parallel::Communicator self(MPI_COMM_SELF);
  const fracture::FractureLaw law(self, parameters, 0, body, {subject.phase.grid.step, subject.stable.step});
  add_criterion(rows, subject, body, law);
  add_waves(rows, parameters, body);
  add_release(rows, subject, body, crack_speed);
  if (!subject.body.crack_starts().empty())
    rows.emplace_back("long branches", quantity_text(analysis::branch_length(parameters.output.branch_length,
                                                                             parameters.mesh, subject.body),
                                                     "m") +
                                           " or more");
  return rows;
}

/// All quantities of sample 0 that need no measurement.
/// @param crack_speed as in print_subject
Rows subject_rows(const FirstSample& subject, double available, double crack_speed) {
  const auto& parameters = subject.parameters;
  const double file =
      ensemble::sample_file_size(parameters.output.frames, subject.n_nodes(), subject.n_tetrahedra());
  const double all = subject.n_samples() * file + ensemble::ensemble_file_size(parameters, subject.n_nodes());
  Rows rows = subject.stand_in ? estimated_rows(subject) : mesh_rows(subject, crack_speed);
  const bool is_exceeded = subject.stable.step < parameters.time.step.value_or(0);
  rows.emplace_back("stable step", (subject.stand_in ? "about " : "") +
                                       quantity_text(subject.stable.step, "s") +
                                       (is_exceeded ? "; samples refuse a time.step above theirs" : ""));
  if (const auto& scaling = subject.stable.mass_scaling)
    rows.emplace_back("mass scaling", dynamics::to_string(*scaling));
  rows.insert(
      rows.end(),
      {{"time step", quantity_text(subject.phase.grid.step, "s")},
       {"steps", fmt::format("{} per dynamic phase", subject.phase.grid.n_steps)},
       {"force evaluations", fmt::format("{} per dynamic phase", subject.phase.force_evaluations)},
       {"memory",
        fmt::format("{:.0f} MB per sample, on {}; {:.3g} GB are available here", subject.memory() / 1e6,
                    count_text(parameters.ensemble.ranks_per_sample, "rank"), available / 1e9)},
       {"output", fmt::format("{:.3g} MB per sample, {:.3g} MB for {}", file / 1e6, all / 1e6,
                              subject.samples_text())}});
  return rows;
}

/// Lists conditions whose regions require a finer mesh than the rest of the input.
std::string refining_regions_text(const input::Parameters& parameters) {
  std::string text;
  for (const geometry::RegionRefinement& one : geometry::region_refinements(parameters))
    text += fmt::format("\nThe region of boundary[{}] makes the mesh as fine as {} there.\n", one.condition,
                        quantity_text(one.spacing, "m"));
  return text;
}

/// Meshes of more nodes take minutes to make and are announced.
constexpr double many_nodes = 1e6;

/// Checks the memory for the mesh only, as the machine that computes the samples may have more memory, or
/// more nodes; and announces a mesh that takes long to make, which a slip in a spacing causes.
/// @return its number of nodes if it takes long; empty: it is to be made
/// @throws std::runtime_error when there is too little memory, or more points than a mesh may have
std::optional<double> check_mesh_size(const input::Parameters& parameters, const geometry::Body& body,
                                      bool makes_mesh) {
  const double n_points = parameters.mesh.points ? 0 : geometry::checked_n_points(body, parameters.mesh);
  const bool takes_long = n_points >= many_nodes;
  if (takes_long) {
    fmt::print("\nWarning: a mesh has about {:.2g} million nodes and takes minutes or more to make: {}\n\n",
               n_points / 1e6, geometry::SpacingField(body, parameters.mesh).range_text());
    std::fflush(stdout);
  }
  if (takes_long && !makes_mesh) return n_points;
  if (const auto message = ensemble::shortage(ensemble::expected_mesh_memory(parameters, body),
                                              "making the mesh", ensemble::available_memory()))
    throw std::runtime_error(*message + "; use coarser spacings, or check the input on a larger machine");
  return std::nullopt;
}

/// The worst tetrahedron of more is worse: from 300,000 to 2.6 million, of plates, by a tenth.
constexpr double of_worse_shapes = 0.9;

FirstSample estimated_subject(const input::Parameters& parameters, const geometry::Body& body,
                              double n_nodes) {
  Heartbeat heartbeat(notify);
  heartbeat.begin("making a coarser mesh");
  auto stand_in = ensemble::make_stand_in(parameters, body, n_nodes);
  auto realization = std::move(stand_in.realization);
  dynamics::StableStep stable = dynamics::stable_step(stand_in.parameters, realization);
  // An estimate refuses no step, neither of the input nor in the measurement.
  const double given = parameters.time.step.value_or(0);
  if (auto& step = stand_in.parameters.time.step) step = std::min(given * stand_in.finest_ratio, stable.step);
  stable.step *= of_worse_shapes / stand_in.finest_ratio;
  const auto phase = ensemble::phase_work(parameters.time, std::max(stable.step, given));
  const double seconds =
      stand_in.mesh_seconds * stand_in.n_nodes / static_cast<double>(realization.nodes.size());
  return {parameters, body, std::move(realization), seconds, stable, phase, std::move(stand_in)};
}

}  // namespace

double FirstSample::memory() const {
  const auto layout = ensemble::one_group(parameters.ensemble.ranks_per_sample);
  const auto demand = ensemble::memory_demand(parameters, n_nodes(), n_tetrahedra(), layout);
  double sum = 0;
  for (int rank = 0; rank < layout.n_ranks; ++rank) sum += demand.of_rank(layout, rank);
  return sum;
}

FirstSample make_subject(const input::Parameters& parameters, const geometry::Body& body,
                         geometry::MotherPoints& base, bool makes_mesh) {
  const auto n_unmade = [&] {
    Heartbeat heartbeat(notify);
    heartbeat.begin("counting the mother points");
    return check_mesh_size(parameters, body, makes_mesh);
  }();
  if (n_unmade) return estimated_subject(parameters, body, *n_unmade);
  if (parameters.mesh.base == input::Base::shared)
    base = ensemble::make_base_points(body, parameters.mesh, parameters.seed, notify);
  const ThreadClock clock;
  Heartbeat heartbeat(notify);
  heartbeat.begin("making the mesh of sample 0");
  auto realization = ensemble::make_sample_realization(body, base, parameters, 0);
  const double seconds = clock.seconds();
  const dynamics::StableStep stable = dynamics::stable_step(parameters, realization);
  const auto phase = ensemble::phase_work(parameters.time, stable.step);
  return {parameters, body, std::move(realization), seconds, stable, phase};
}

void print_subject(const FirstSample& subject, const ensemble::AvailableMemory& available,
                   double crack_speed) {
  const auto& parameters = subject.parameters;
  fmt::print("{}{}", aligned(subject_rows(subject, available.bytes, crack_speed)),
             refining_regions_text(parameters));
  for (const auto& warning : dynamics::resolution_warnings(parameters, subject.body, subject.phase.grid.step))
    fmt::print("\nWarning: {}\n", warning);
  for (const std::size_t crack : idle_pre_cracks(subject))
    fmt::print(
        "\nWarning: specimen.crack[{}] opens nothing: it lies outside the body, between its nodes or on a "
        "crack before it\n",
        crack);
  const int n_ranks = parameters.ensemble.ranks_per_sample;
  const std::string whose = n_ranks == 1 ? "a sample" : fmt::format("the {} ranks of a sample", n_ranks);
  if (const auto message = ensemble::shortage(subject.memory(), whose, available))
    fmt::print(
        "\nWarning: cannot be computed on this machine: {}; use a larger machine, coarser spacings, more "
        "nodes, or more ranks_per_sample\n",
        *message);
  std::fflush(stdout);
}

}  // namespace crackle::apps
