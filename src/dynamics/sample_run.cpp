// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/sample_run.h"

#include "crackle/dynamics/explicit_phase.h"
#include "crackle/dynamics/quasi_static.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/fracture/toughness.h"
#include "crackle/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>

namespace crackle::dynamics {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Seconds between two lines about a running phase.
constexpr double report_interval = 20;

/// Time without a break after which a dynamic phase has arrested: a shear wave crosses the body's middle
/// extent, so what a break sends out has come back to the crack from the sides.
double arrest_window(const input::Parameters& parameters) {
  if (parameters.time.arrest) return *parameters.time.arrest;
  auto size = parameters.specimen.size;
  std::ranges::sort(size);
  const mechanics::IsotropicElasticity elasticity(parameters.material);
  return size[1] / std::sqrt(elasticity.mu / parameters.material.density);
}

std::vector<fracture::Break> gather_breaks(const parallel::Communicator& group,
                                           std::span<const fracture::Break> local) {
  static_assert(std::is_trivially_copyable_v<fracture::Break>);
  const int n_bytes = static_cast<int>(local.size_bytes());
  std::vector<int> counts(static_cast<std::size_t>(group.size()));
  parallel::check_mpi(MPI_Gather(&n_bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, group.get()),
                      "MPI_Gather");
  std::vector<int> offsets(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<fracture::Break> all;
  if (group.is_root()) {
    all.resize(static_cast<std::size_t>(offsets.back() + counts.back()) / sizeof(fracture::Break));
  }
  parallel::check_mpi(MPI_Gatherv(local.data(), n_bytes, MPI_BYTE, all.data(), counts.data(), offsets.data(),
                                  MPI_BYTE, 0, group.get()),
                      "MPI_Gatherv");
  std::ranges::sort(
      all, {}, [](const fracture::Break& b) { return std::tuple(b.load_time, b.phase_time, b.tetrahedron); });
  return all;
}

/// One sample on its way; the phases in the order in which they happen.
class SampleRun {
public:
  SampleRun(const parallel::Communicator& group, const input::Parameters& parameters,
            const geometry::Subdomain& subdomain, const SampleLog& log)
      : group_(group),
        parameters_(parameters),
        subdomain_(subdomain),
        log_(log),
        body_(subdomain, parameters.material, parameters.fracture.release, parameters.fracture.contact),
        loads_(mechanics::make_boundary_loads(group, parameters, subdomain)),
        criterion_(parameters.fracture,
                   fracture::tetrahedron_strengths(group, parameters, subdomain, body_.operators())),
        splitting_(splitting(parameters.time.integrator)),
        account_(group, body_),
        context_{&group_, &body_, &loads_, parameters.material.density, criterion_.strengths()} {
    result_.stable_step =
        splitting_.stability_limit / largest_frequency(group, subdomain, body_.operators(), body_.force());
    options_.grid = choose_time_grid(parameters.time, result_.stable_step);
    options_.n_frames = parameters.output.frames;
    result_.time_step = options_.grid.step;
    result_.onset_time = nan;
    result_.onset_force = nan;
    result_.timings.setup = setup_watch_.seconds();
    say(fmt::format("{} nodes, {} tetrahedra; stable step {:.3g} ns, used {:.4g} ns, {} steps",
                    subdomain.n_nodes_global, subdomain.n_tetrahedra_global, 1e9 * result_.stable_step,
                    1e9 * result_.time_step, options_.grid.n_steps));
  }

  SampleResult run() {
    if (parameters_.time.start == input::Start::rest) {
      MotionState state = at_rest();
      move(0, state);
      result_.outcome = loads_are_held(group_, body_, loads_) ? Outcome::running : Outcome::separated;
    } else {
      load_until_end();
    }
    finish();
    return std::move(result_);
  }

private:
  void say(const std::string& line) const {
    if (log_ && group_.is_root()) log_(line);
  }

  void load_until_end() {
    options_.arrest_window = arrest_window(parameters_);
    Stopwatch watch;
    QuasiStaticLoading loading(group_, body_, loads_, criterion_, *options_.arrest_window);
    for (;;) {
      const QuasiStaticEnd end = loading.advance(account_);
      result_.counts.quasi_static_breaks = loading.n_breaks();
      result_.counts.static_solves = loading.n_solves();
      result_.counts.solver_iterations = loading.n_iterations();
      result_.timings.quasi_static += watch.seconds();
      if (end != QuasiStaticEnd::run_away) {
        const bool broke = result_.counts.dynamic_phases > 0 || loading.n_breaks() > 0;
        result_.outcome = end == QuasiStaticEnd::separated ? Outcome::separated
                          : broke                          ? Outcome::arrested
                                                           : Outcome::unbroken;
        if (result_.energy.empty()) {
          result_.energy.push_back(account_.row(0, 0, 0, loading.displacement()));
        }
        return;
      }
      MotionState state = at_rest();
      state.displacement.assign(loading.displacement());
      const PhaseResult phase = move(loading.time(), state);
      watch = Stopwatch();
      if (!phase.arrested) {
        result_.outcome = loads_are_held(group_, body_, loads_) ? Outcome::running : Outcome::separated;
        return;
      }
      account_.add_external(phase.external_work);
      if (!loading.resume(loading.time() + phase.time, phase.kinetic, state.displacement, account_)) {
        result_.outcome = Outcome::separated;
        return;
      }
    }
  }

  MotionState at_rest() const {
    return {parallel::NodeField(group_, subdomain_), parallel::NodeField(group_, subdomain_)};
  }

  PhaseResult move(double load_time, MotionState& state) {
    result_.onset_time = load_time;
    result_.onset_force = onset_force(load_time, state.displacement);
    ++result_.counts.dynamic_phases;
    say(fmt::format(
        "run-away at t = {:.6f} s, {:.2f} N, after {} quasi-static breaks and {} static solves with {} "
        "iterations in {:.1f} s; dynamic phase {} starts",
        load_time, result_.onset_force, result_.counts.quasi_static_breaks, result_.counts.static_solves,
        result_.counts.solver_iterations, result_.timings.quasi_static, result_.counts.dynamic_phases));
    Stopwatch watch;
    double last_report = 0;
    PhaseOptions options = options_;
    options.on_row = [&](const EnergyRow& row) {
      if (watch.seconds() < last_report + report_interval) return;
      last_report = watch.seconds();
      const double duration = static_cast<double>(options_.grid.n_steps) * options_.grid.step;
      say(fmt::format("dynamic phase {}: {:.1f} of {:.1f} us, {} tetrahedra broken, {:.0f} s left at most",
                      result_.counts.dynamic_phases, 1e6 * row.time, 1e6 * duration, row.broken,
                      watch.seconds() * (duration / row.time - 1)));
    };
    const double duration = static_cast<double>(options_.grid.n_steps) * options_.grid.step;
    const auto motion =
        make_fixed_point_motion(context_, parameters_.time.precision, load_time, duration, state);
    PhaseResult phase =
        run_explicit_phase(context_, *motion, criterion_, splitting_, account_, load_time, options, state);
    result_.timings.dynamic += watch.seconds();
    result_.counts.steps += phase.n_steps;
    result_.counts.force_evaluations += phase.n_forces;
    result_.energy = std::move(phase.energy);
    result_.frames = std::move(phase.frames);
    say(fmt::format("dynamic phase {}: {} after {:.1f} us, {} tetrahedra broken so far",
                    result_.counts.dynamic_phases, phase.arrested ? "arrested" : "complete", 1e6 * phase.time,
                    result_.energy.back().broken));
    return phase;
  }

  double onset_force(double load_time, const parallel::NodeField& displacement) const {
    double largest = loads_.largest_force(load_time);
    const LoadState state = measure_loads(group_, body_, loads_, displacement, load_time);
    for (std::size_t m = 0; m < loads_.motions.size(); ++m) {
      if (!loads_.motions[m].is_fixed) largest = std::max(largest, std::abs(state.reaction[m]));
    }
    return largest;
  }

  void finish() {
    result_.energy_error = energy_error(result_.energy);
    result_.breaks = gather_breaks(group_, body_.breaks());
    if (result_.timings.dynamic > 0) {
      result_.timings.element_updates_per_second = static_cast<double>(subdomain_.n_tetrahedra_global) *
                                                   static_cast<double>(result_.counts.force_evaluations) /
                                                   result_.timings.dynamic;
    }
  }

  Stopwatch setup_watch_;
  const parallel::Communicator& group_;
  const input::Parameters& parameters_;
  const geometry::Subdomain& subdomain_;
  const SampleLog& log_;
  fracture::BreakableBody body_;
  mechanics::BoundaryLoads loads_;
  fracture::TulerButcher criterion_;
  const Splitting& splitting_;
  EnergyAccount account_;
  MotionContext context_;
  PhaseOptions options_;
  SampleResult result_;
};

}  // namespace

std::string to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::unbroken:
      return "unbroken";
    case Outcome::arrested:
      return "arrested";
    case Outcome::separated:
      return "separated";
    case Outcome::running:
      return "running";
  }
  return "unknown";
}

SampleResult run_sample(const parallel::Communicator& group, const input::Parameters& parameters,
                        const geometry::Subdomain& subdomain, const SampleLog& log) {
  try {
    return SampleRun(group, parameters, subdomain, log).run();
  } catch (const NumberRangeExceeded& error) {
    if (parameters.time.precision != input::Precision::mixed) throw;
    if (log && group.is_root()) log(fmt::format("{}; the sample is computed again in double", error.what()));
  }
  input::Parameters in_double = parameters;
  in_double.time.precision = input::Precision::double_;
  SampleResult result = SampleRun(group, in_double, subdomain, log).run();
  result.counts.range_restarts = 1;
  return result;
}

}  // namespace crackle::dynamics
