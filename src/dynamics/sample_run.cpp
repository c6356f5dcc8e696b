// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/sample_run.h"

#include "crackle/dynamics/checkpoint.h"
#include "crackle/dynamics/explicit_phase.h"
#include "crackle/dynamics/quasi_static.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/fracture/toughness.h"
#include "crackle/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

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

/// The checkpoint tells of another sample than this one.
class CheckpointMismatch : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

constexpr const char* mismatch_text = "the quasi-static loading does not lead to its dynamic phases";

/// One sample on its way; the phases in the order in which they happen.
class SampleRun {
public:
  SampleRun(const parallel::Communicator& group, const input::Parameters& parameters,
            const geometry::Subdomain& subdomain, const SampleControl& control, const Checkpoint* from)
      : group_(group),
        parameters_(parameters),
        subdomain_(subdomain),
        control_(control),
        from_(from),
        body_(subdomain, parameters.material, parameters.fracture.release, parameters.fracture.contact),
        loads_(mechanics::make_boundary_loads(group, parameters, subdomain)),
        splitting_(splitting(parameters.time.integrator)),
        stable_step_(splitting_.stability_limit /
                     largest_frequency(group, subdomain, body_.operators(), body_.force())),
        options_{.grid = choose_time_grid(parameters.time, stable_step_),
                 .n_frames = parameters.output.frames},
        criterion_(parameters.fracture,
                   fracture::tetrahedron_strengths(group, parameters, subdomain, body_.operators()),
                   options_.grid.step),
        account_(group, body_),
        context_{&group_,
                 &body_,
                 &loads_,
                 parameters.material.density,
                 criterion_.strengths(),
                 criterion_.watched_share(stable_step_)} {
    result_.stable_step = stable_step_;
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
      if (move(0, state).parked) return parked();
      result_.outcome = loads_are_held(group_, body_, loads_) ? Outcome::running : Outcome::separated;
    } else if (!load_until_end()) {
      return parked();
    }
    finish();
    return std::move(result_);
  }

private:
  void say(const std::string& line) const {
    if (control_.log && group_.is_root()) control_.log(line);
  }

  SampleResult parked() {
    result_.parked = true;
    return std::move(result_);
  }

  /// @return false when the sample was parked
  bool load_until_end() {
    options_.arrest_window = arrest_window(parameters_);
    Stopwatch watch;
    QuasiStaticLoading loading(group_, body_, loads_, criterion_, *options_.arrest_window);
    for (;;) {
      const QuasiStaticEnd end = loading.advance(account_, control_.stop);
      result_.counts.quasi_static_breaks = loading.n_breaks();
      result_.counts.static_solves = loading.n_solves();
      result_.counts.solver_iterations = loading.n_iterations();
      result_.timings.quasi_static += watch.seconds();
      if (end == QuasiStaticEnd::parked) {
        if (!ended_.empty())
          save({parameters_.time.precision, ended_, {}, impulse(), result_.energy, result_.frames});
        return false;
      }
      if (end != QuasiStaticEnd::run_away) {
        const bool broke = result_.counts.dynamic_phases > 0 || loading.n_breaks() > 0;
        result_.outcome = end == QuasiStaticEnd::separated ? Outcome::separated
                          : broke                          ? Outcome::arrested
                                                           : Outcome::unbroken;
        if (result_.energy.empty()) {
          result_.energy.push_back(account_.row(0, 0, 0, loading.displacement()));
        }
        return true;
      }
      MotionState state = at_rest();
      state.displacement.assign(loading.displacement());
      const PhaseResult phase = move(loading.time(), state);
      watch = Stopwatch();
      if (phase.parked) return false;
      if (!phase.arrested) {
        result_.outcome = loads_are_held(group_, body_, loads_) ? Outcome::running : Outcome::separated;
        return true;
      }
      account_.add_external(phase.external_work);
      if (!loading.resume(loading.time() + phase.time, phase.kinetic, state.displacement, account_)) {
        result_.outcome = Outcome::separated;
        return true;
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
    const auto phase_number = static_cast<std::size_t>(result_.counts.dynamic_phases - 1);
    if (from_ != nullptr && phase_number < from_->ended.size())
      return replay(from_->ended[phase_number], load_time, state);
    Stopwatch watch;
    double last_report = 0;
    PhaseOptions options = options_;
    if (from_ != nullptr && phase_number == from_->ended.size() && from_->running) {
      if (from_->running->load_time != load_time) throw CheckpointMismatch(mismatch_text);
      options.from = from_;
      say(fmt::format("dynamic phase {} goes on at step {}", result_.counts.dynamic_phases,
                      from_->running->step));
    }
    if (control_.stop || control_.save) {
      options.request = [&] {
        if (control_.stop && control_.stop()) return Request::park;
        const bool is_due =
            group_.is_root() && since_save_.seconds() >= control_.checkpoint_interval && control_.save;
        return is_due ? Request::save : Request::go_on;
      };
      options.save = [&](RunningPhase phase, const std::vector<EnergyRow>& energy,
                         const std::vector<Frame>& frames) {
        save({parameters_.time.precision, ended_, std::move(phase), impulse(), energy, frames});
      };
    }
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
    const ReleasesSince releases(body_);
    PhaseResult phase =
        run_explicit_phase(context_, *motion, criterion_, splitting_, account_, load_time, options, state);
    result_.timings.dynamic += watch.seconds();
    const Traffic traffic = motion->traffic();
    result_.timings.traffic.n_exchanges += traffic.n_exchanges;
    result_.timings.traffic.seconds += traffic.seconds;
    result_.timings.traffic.bytes_per_exchange = traffic.bytes_per_exchange;
    if (phase.parked) return phase;
    if (phase.arrested && control_.save) {
      ended_.push_back({load_time, phase.time, phase.kinetic, phase.external_work, phase.n_steps,
                        phase.n_forces, releases.gather(group_), gather_displacement(state)});
    }
    result_.counts.steps += phase.n_steps;
    result_.counts.force_evaluations += phase.n_forces;
    result_.energy = std::move(phase.energy);
    result_.frames = std::move(phase.frames);
    say(fmt::format("dynamic phase {}: {} after {:.1f} us, {} tetrahedra broken so far",
                    result_.counts.dynamic_phases, phase.arrested ? "arrested" : "complete", 1e6 * phase.time,
                    result_.energy.back().broken));
    return phase;
  }

  /// What an earlier run has computed of an arrested phase.
  PhaseResult replay(const EndedPhase& ended, double load_time, MotionState& state) {
    const auto n_nodes = static_cast<std::size_t>(subdomain_.n_nodes_global);
    if (ended.load_time != load_time || ended.displacement.numbers.size() != n_nodes)
      throw CheckpointMismatch(mismatch_text);
    say(fmt::format("dynamic phase {} is taken from the checkpoint", result_.counts.dynamic_phases));
    body_.restore(ended.releases.breaks, ended.releases.ties);
    const auto u = state.displacement.local();
    for (std::size_t i = 0; i < u.size(); ++i) {
      const auto row = ended.displacement.find(subdomain_.node_number[i / 3]);
      u[i] = std::bit_cast<double>(row[i % 3]);
    }
    ended_.push_back(ended);
    restore_impulse(from_->impulse, subdomain_, criterion_);
    result_.energy = from_->energy;
    result_.frames = from_->frames;
    result_.counts.steps += ended.n_steps;
    result_.counts.force_evaluations += ended.n_forces;
    PhaseResult phase;
    phase.arrested = true;
    phase.time = ended.time;
    phase.kinetic = ended.kinetic;
    phase.external_work = ended.external_work;
    return phase;
  }

  parallel::NumberedRows gather_displacement(const MotionState& state) const {
    parallel::NumberedRows local;
    local.width = 3;
    const auto u = state.displacement.owned();
    for (std::size_t n = 0; 3 * n < u.size(); ++n) {
      local.numbers.push_back(subdomain_.node_number[n]);
      for (std::size_t c = 0; c < 3; ++c) local.values.push_back(std::bit_cast<std::int64_t>(u[3 * n + c]));
    }
    return parallel::gather_rows(group_, local);
  }

  parallel::NumberedRows impulse() const { return gather_impulse(group_, subdomain_, criterion_); }

  /// A checkpoint that cannot be kept is no reason to end the sample.
  void save(const Checkpoint& checkpoint) {
    since_save_ = Stopwatch();
    if (!control_.save || !group_.is_root()) return;
    try {
      control_.save(to_bytes(checkpoint));
    } catch (const std::exception& error) {
      say(fmt::format("the checkpoint could not be kept: {}", error.what()));
    }
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
  const SampleControl& control_;
  const Checkpoint* from_;  // nullptr: from the start
  fracture::BreakableBody body_;
  mechanics::BoundaryLoads loads_;
  const Splitting& splitting_;
  double stable_step_;
  PhaseOptions options_;
  fracture::TulerButcher criterion_;
  EnergyAccount account_;
  MotionContext context_;
  SampleResult result_;
  std::vector<EndedPhase> ended_;  // breaks and displacements on the root, or from the checkpoint
  Stopwatch since_save_;
};

/// The sample in the precision of the input, or in double where mixed numbers do not suffice. Collective.
/// @param from nullptr: from the start
/// @throws CheckpointMismatch on every rank when the checkpoint tells of another sample
SampleResult run_in_fitting_precision(const parallel::Communicator& group,
                                      const input::Parameters& parameters,
                                      const geometry::Subdomain& subdomain, const SampleControl& control,
                                      const Checkpoint* from) {
  const auto say = [&](const std::string& line) {
    if (control.log && group.is_root()) control.log(line);
  };
  const bool is_mixed = parameters.time.precision == input::Precision::mixed;
  if (from == nullptr || from->precision == parameters.time.precision) {
    try {
      return SampleRun(group, parameters, subdomain, control, from).run();
    } catch (const NumberRangeExceeded& error) {
      if (!is_mixed) throw;
      say(fmt::format("{}; the sample is computed again in double", error.what()));
    }
    from = nullptr;
  } else if (is_mixed) {
    say("the sample goes on in double: an earlier run has left the range of mixed numbers");
  } else {
    throw CheckpointMismatch("it was made in mixed numbers");
  }
  input::Parameters in_double = parameters;
  in_double.time.precision = input::Precision::double_;
  SampleResult result = SampleRun(group, in_double, subdomain, control, from).run();
  result.counts.range_restarts = 1;
  return result;
}

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
                        const geometry::Subdomain& subdomain, const SampleControl& control) {
  bool has_checkpoint = !control.checkpoint.empty();
  parallel::check_mpi(MPI_Bcast(&has_checkpoint, 1, MPI_CXX_BOOL, 0, group.get()), "MPI_Bcast");
  if (has_checkpoint) {
    // Every rank has the same checkpoint, so all of them refuse it or none.
    std::optional<Checkpoint> from;
    try {
      try {
        from = share_checkpoint(group, control.checkpoint);
      } catch (const std::runtime_error&) {
        throw CheckpointMismatch("it is not complete");
      }
      return run_in_fitting_precision(group, parameters, subdomain, control, &*from);
    } catch (const CheckpointMismatch& mismatch) {
      if (control.log && group.is_root())
        control.log(fmt::format("the checkpoint is not used: {}", mismatch.what()));
    }
  }
  return run_in_fitting_precision(group, parameters, subdomain, control, nullptr);
}

}  // namespace crackle::dynamics
