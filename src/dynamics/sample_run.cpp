// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/sample_run.h"

#include "crackle/common/freed_memory.h"
#include "crackle/common/index.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/real.h"
#include "crackle/common/stopwatch.h"
#include "crackle/dynamics/checkpoint.h"
#include "crackle/dynamics/explicit_phase.h"
#include "crackle/dynamics/history.h"
#include "crackle/dynamics/machine_load.h"
#include "crackle/dynamics/quasi_static.h"
#include "crackle/dynamics/sample_setup.h"
#include "crackle/dynamics/separation.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include "loose_loads.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Memory needed to analyse and write a sample, beyond the sample itself [byte].
constexpr std::size_t room_for_keeping = std::size_t{64} << 20;

/// Seconds between two lines about a running phase.
constexpr double report_interval = 20;

/// The checkpoint belongs to a different sample.
class CheckpointMismatch : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

constexpr const char* mismatch_text = "the quasi-static loading does not reproduce its dynamic phases";

/// A sample run; its phases in chronological order.
class SampleRun {
public:
  SampleRun(const parallel::Communicator& group, const input::Parameters& parameters,
            const geometry::Subdomain& subdomain, const SampleControl& control, const Checkpoint* from)
      : group_(group),
        parameters_(parameters),
        subdomain_(subdomain),
        control_(control),
        from_(from),
        setup_(group, parameters, subdomain, control.sample),
        options_{.grid = setup_.grid,
                 .n_frames = parameters.output.frames,
                 .history_interval = parameters.output.history},
        account_(group, body_),
        history_(group, body_, loads_, account_, parameters.output.probes),
        context_{&group_,
                 &body_,
                 &loads_,
                 parameters.material.density,
                 criterion_.get(),
                 criterion_->screening_share(setup_.stable_step),
                 average_.get(),
                 parameters.damping_rate(),
                 setup_.vicinity.get()} {
    result_.stable_step = setup_.stable_step;
    if (from_ != nullptr) first_break_reaction_ = from_->first_break_reaction;
    result_.load_is_reaction = machine_reacts();
    options_.release_time = parameters_.fracture.release_time;
    result_.time_step = options_.grid.step;
    result_.timings.setup = setup_watch_.seconds();
    say(fmt::format("{} nodes, {} tetrahedra; stable step {:.3g} ns, used {:.4g} ns, {} steps",
                    subdomain.layout.n_global, subdomain.n_tetrahedra_global, 1e9 * result_.stable_step,
                    1e9 * result_.time_step, options_.grid.n_steps));
  }

  SampleResult run() {
    try {
      // A failure on one rank is thrown on all of them here, after they have saved the partial results
      // together.
      parallel::together<NumberRangeExceeded, CheckpointMismatch>(group_, [&] {
        const bool is_parked =
            parameters_.time.start == input::Start::rest ? !move_from_rest() : !load_until_end();
        if (is_parked) {
          result_.parked = true;
        } else {
          group_.enter("results");
          finish();
        }
      });
    } catch (const parallel::AgreedError&) {
      keep_what_there_is();
      throw;
    } catch (const NumberRangeExceeded&) {
      keep_what_there_is();
      throw;
    }
    return std::move(result_);
  }

private:
  void say(const std::string& line) const {
    if (control_.log && group_.is_root()) control_.log(line);
  }

  /// @return false when the sample was parked
  bool move_from_rest() {
    MotionState state = at_rest();
    // Displacements imposed instantaneously, before the body can follow, strain it; the drive supplies that
    // energy.
    loads_.set_displacements(0, state.displacement.owned());
    parallel::agree(group_);
    state.displacement.update_ghosts();
    account_.add_phase(strain_energy(group_, body_, state.displacement.local()), 0);
    say("dynamic phase 1 starts from rest");
    const PhaseResult phase = move(0, state);
    if (phase.parked) return false;
    result_.separated_at = phase.separated_at;
    result_.outcome = !has_broken()     ? Outcome::unbroken
                      : phase.separated ? Outcome::separated
                                        : Outcome::running;
    return true;
  }

  template <class MakeLine>
  void show(const MakeLine& make_line) const {
    if (control_.progress && group_.is_root()) control_.progress(make_line());
  }

  /// @return false when the sample was parked
  bool load_until_end() {
    options_.arrest_window = arrest_window(parameters_);
    Stopwatch watch;
    group_.enter("quasi-static loading");
    setup_.refuse_free_body();
    QuasiStaticLoading loading(group_, body_, loads_, *criterion_, *options_.arrest_window, average_.get(),
                               &loads_, setup_.vicinity.get());
    release_freed_memory();
    loading.load_at_start(account_);
    bool is_first = parameters_.time.start == input::Start::equilibrium;
    if (!is_first) loading.refuse_overload();
    const auto look = [&] {
      show([&] {
        return fmt::format("quasi-static loading: {} breaks, {} static solves", loading.n_breaks(),
                           loading.n_solves());
      });
      return control_.stop();
    };
    for (;; is_first = false) {
      const QuasiStaticEnd end =
          is_first
              ? QuasiStaticEnd::unstable
              : loading.advance(account_, control_.stop ? std::function<bool()>(look) : nullptr,
                                [&](const LoadState& loads) {
                                  history_.record_equilibrium(loading.time(), loads, loading.displacement());
                                });
      result_.counts.quasi_static_breaks = loading.n_breaks();
      result_.counts.static_solves = loading.n_solves();
      result_.counts.solver_iterations = loading.n_iterations();
      result_.equilibrium_residual = loading.residual();
      load_at_first_break_ = loading.load_at_first_break();
      result_.timings.quasi_static += watch.seconds();
      if (end == QuasiStaticEnd::parked) {
        group_.enter("saving");
        if (is_past_checkpoint()) save(checkpoint({}, result_.energy, result_.frames));
        return false;
      }
      if (end != QuasiStaticEnd::unstable) {
        result_.outcome = !has_broken() ? Outcome::unbroken
                          : end == QuasiStaticEnd::separated || is_separated(group_, body_, loads_)
                              ? Outcome::separated
                              : Outcome::arrested;
        if (result_.energy.empty()) {
          result_.energy.push_back(
              account_.row(0, {.strain = strain_energy(group_, body_, loading.displacement().local())}));
        }
        return true;
      }
      result_.onset_time = loading.time();
      result_.onset_force = loading.load();
      say(fmt::format(
          "{} at t = {:.6f} s, {}, after {} quasi-static breaks and {} static solves with {} "
          "iterations in {:.1f} s; dynamic phase {} starts",
          is_first ? "equilibrium" : "instability", loading.time(), quantity_text(loading.load(), "N"),
          loading.n_breaks(), loading.n_solves(), loading.n_iterations(), result_.timings.quasi_static,
          result_.counts.dynamic_phases + 1));
      MotionState state = at_rest();
      state.displacement.assign(loading.displacement());
      const PhaseResult phase = move(loading.time(), state);
      watch = Stopwatch();
      if (phase.parked) return false;
      result_.separated_at = phase.separated_at;
      if (!phase.arrested) {
        result_.outcome = phase.separated ? Outcome::separated : Outcome::undecided;
        return true;
      }
      group_.enter("quasi-static loading");
      account_.add_phase(phase.external_work, phase.dissipated);
      if (!loading.resume(loading.time() + phase.time, phase.kinetic, state.displacement, account_)) {
        result_.outcome = Outcome::separated;
        if (std::isnan(result_.separated_at)) result_.separated_at = phase.last_break;
        return true;
      }
      result_.separated_at = SampleResult::none;
      counted_time_ = infinity;  // loading continues from all breaks
    }
  }

  /// True if this run has passed the state of the sample's checkpoint: more phases have ended than it
  /// contains.
  bool is_past_checkpoint() const { return ended_.size() > (from_ == nullptr ? 0 : from_->ended.size()); }

  /// True if anything has broken. Collective.
  bool has_broken() const {
    parallel::agree(group_);
    return parallel::any_of_all(group_, !body_.breaks().empty());
  }

  MotionState at_rest() const {
    return {parallel::NodeField(group_, subdomain_.layout), parallel::NodeField(group_, subdomain_.layout)};
  }

  PhaseResult move(double load_time, MotionState& state) {
    group_.enter("dynamic phase");
    result_.phase_start = load_time;
    ++result_.counts.dynamic_phases;
    const auto number = static_cast<std::int32_t>(result_.counts.dynamic_phases);
    const auto phase_number = index(number - 1);
    if (from_ != nullptr && phase_number < from_->ended.size())
      return replay(from_->ended[phase_number], load_time, state);
    Stopwatch watch;
    double last_report = 0;
    PhaseOptions options = options_;
    if (from_ != nullptr && phase_number == from_->ended.size() && from_->running) {
      if (from_->running->load_time != load_time) throw CheckpointMismatch(mismatch_text);
      options.from = from_;
      history_.append(from_->running->history);
      say(fmt::format("dynamic phase {} continues at step {}", result_.counts.dynamic_phases,
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
        phase.history = history_.rows_of_phase(number);
        save(checkpoint(std::move(phase), energy, frames));
      };
    }
    // Applied forces are known analytically; only reactions must be recorded.
    if (machine_reacts() && !has_broken()) {
      options.on_first_break = [&](double time, const MotionState& now) {
        LoadState loads = measure_loads(group_, body_, loads_, now.displacement, time, &now.velocity);
        std::ranges::fill(loads.amplitude, 0.0);
        first_break_reaction_ = machine_load(loads_, loads).force;
      };
    }
    options.on_history = [&](const EnergyRow& row, const MotionState& now) {
      history_.record_motion(number, load_time, row, now.displacement, now.velocity);
    };
    options.on_failure = [&](PhaseResult partial) {
      result_.energy = std::move(partial.energy);
      result_.frames = std::move(partial.frames);
    };
    const double duration = options_.grid.duration();
    const double first_time =
        options.from != nullptr ? static_cast<double>(options.from->running->step) * options_.grid.step : 0;
    options.on_row = [&](const EnergyRow& row) {
      if (!(row.time > first_time)) return;
      const auto line = [&] {
        return fmt::format(
            "dynamic phase {}: {:.0f} %, {:.1f} of {:.1f} us, {} tetrahedra broken, {:.0f} s left at most",
            result_.counts.dynamic_phases, 100 * row.time / duration, 1e6 * row.time, 1e6 * duration,
            row.broken, watch.seconds() * (duration - row.time) / (row.time - first_time));
      };
      show(line);
      if (control_.progress || watch.seconds() < last_report + report_interval) return;
      last_report = watch.seconds();
      say(line());
    };
    const auto motion = make_motion(context_, parameters_.time, load_time, duration, state);
    if (parameters_.time.after_separation > 0) options.after_separation = parameters_.time.after_separation;
    options.ending_loads = &loads_;
    options.ends_out_of_range = parameters_.time.precision == input::Precision::double_;
    const ReleasesSince releases(body_);
    PhaseResult phase =
        run_explicit_phase(context_, *motion, setup_.splitting, account_, load_time, options, state);
    result_.timings.dynamic += watch.seconds();
    const ExchangeCost exchange_cost = motion->exchange_cost();
    result_.timings.exchange_cost.n_exchanges += exchange_cost.n_exchanges;
    result_.timings.exchange_cost.seconds += exchange_cost.seconds;
    result_.timings.exchange_cost.bytes_per_exchange = exchange_cost.bytes_per_exchange;
    if (phase.parked) return phase;
    if (phase.arrested && control_.save) {
      ended_.push_back({load_time, phase.time, phase.kinetic, phase.external_work, phase.dissipated,
                        phase.separated_at, phase.last_break, phase.n_steps, phase.n_forces,
                        releases.gather(group_), gather_displacement(state), history_.rows_of_phase(number),
                        gather_ended_loads(group_, subdomain_.layout, loads_)});
    }
    result_.counts.steps += phase.n_steps;
    result_.counts.force_evaluations += phase.n_forces;
    result_.energy = std::move(phase.energy);
    result_.frames = std::move(phase.frames);
    result_.note = phase.note;
    counted_time_ = phase.counted_time;
    say(fmt::format("dynamic phase {}: {} after {:.1f} us, {} tetrahedra broken so far",
                    result_.counts.dynamic_phases,
                    phase.arrested    ? "arrested"
                    : phase.separated ? "the body is apart"
                                      : "complete",
                    1e6 * phase.time, result_.energy.back().broken));
    if (!phase.note.empty()) say(phase.note);
    return phase;
  }

  /// Restores an arrested phase computed by an earlier run.
  PhaseResult replay(const EndedPhase& ended, double load_time, MotionState& state) {
    const auto n_nodes = static_cast<std::size_t>(subdomain_.layout.n_global);
    if (ended.load_time != load_time || ended.displacement.numbers.size() != n_nodes)
      throw CheckpointMismatch(mismatch_text);
    say(fmt::format("dynamic phase {} is taken from the checkpoint", result_.counts.dynamic_phases));
    const std::size_t n_changes = body_.changes().size();
    body_.restore(ended.releases);
    fracture::update_strengths(*criterion_, body_, body_.changes().subspan(n_changes));
    const auto u = state.displacement.local();
    for (std::size_t i = 0; i < u.size(); ++i) {
      const auto row = ended.displacement.find(subdomain_.layout.number[i / 3]);
      u[i] = std::bit_cast<double>(row[i % 3]);
    }
    restore_ended_loads(group_, subdomain_.layout, ended.ended_loads, loads_);
    ended_.push_back(ended);
    history_.append(ended.history);
    restore_memory(from_->memory, subdomain_, *criterion_);
    result_.energy = from_->energy;
    result_.frames = from_->frames;
    result_.counts.steps += ended.n_steps;
    result_.counts.force_evaluations += ended.n_forces;
    counted_time_ = std::min(ended.time, options_.grid.duration());
    PhaseResult phase;
    phase.arrested = true;
    phase.time = ended.time;
    phase.kinetic = ended.kinetic;
    phase.external_work = ended.external_work;
    phase.dissipated = ended.dissipated;
    phase.separated_at = ended.separated_at;
    phase.last_break = ended.last_break;
    return phase;
  }

  /// True if the machine's load is, at least in part, a reaction.
  bool machine_reacts() const {
    return std::ranges::any_of(loads_.governing, [&](const mechanics::GoverningCondition& governing) {
      const auto is_governing = [&](const auto& one) { return one.condition == governing.condition; };
      return std::ranges::any_of(loads_.motions, is_governing) ||
             std::ranges::any_of(loads_.absorbers, is_governing);
    });
  }

  /// The machine's load without reactions [N].
  double applied_load(double time) const {
    LoadState state;
    for (const auto& pattern : loads_.forces) state.amplitude.push_back(pattern.amplitude.at(time));
    state.position.resize(loads_.forces.size());
    state.reaction.resize(loads_.motions.size());
    state.travel.resize(loads_.motions.size());
    return machine_load(whole_loads_, state).force;
  }

  parallel::NumberedRows gather_displacement(const MotionState& state) const {
    parallel::NumberedRows local;
    local.width = 3;
    const auto u = state.displacement.owned();
    for (std::size_t n = 0; 3 * n < u.size(); ++n) {
      local.numbers.push_back(subdomain_.layout.number[n]);
      for (std::size_t c = 0; c < 3; ++c) local.values.push_back(std::bit_cast<std::int64_t>(u[3 * n + c]));
    }
    return parallel::gather_rows(group_, local);
  }

  parallel::NumberedRows memory() const { return gather_memory(group_, subdomain_, *criterion_); }

  /// Failing to store a checkpoint does not end the sample.
  void save(const Checkpoint& checkpoint) {
    since_save_ = Stopwatch();
    if (!control_.save || !group_.is_root()) return;
    try {
      control_.save(to_bytes(checkpoint));
    } catch (const std::exception& error) {
      say(fmt::format("the checkpoint could not be kept: {}", error.what()));
    }
  }

  Checkpoint checkpoint(std::optional<RunningPhase> running, const std::vector<EnergyRow>& energy,
                        const std::vector<Frame>& frames) const {
    return {.precision = parameters_.time.precision,
            .engine = parameters_.time.engine,
            .first_break_reaction = first_break_reaction_,
            .ended = ended_,
            .running = std::move(running),
            .memory = memory(),
            .energy = energy,
            .frames = frames};
  }

  void finish() {
    result_.breaks = gather_breaks(group_, body_.breaks());
    result_.bridge_releases = gather_bridge_releases(group_, body_.bridge_releases());
    result_.tooth_falls = gather_tooth_falls(group_, body_.tooth_falls());
    // Breaks after the duration of the last phase only served to show that it was the last one.
    const bool is_last = std::ranges::none_of(
        result_.breaks, [&](const fracture::Break& one) { return one.load_time > result_.phase_start; });
    if (!is_last) counted_time_ = infinity;
    const auto is_uncounted = [&](const EnergyRow& row) { return row.time > counted_time_; };
    std::erase_if(result_.energy, is_uncounted);
    result_.history = history_.rows();
    std::erase_if(result_.history, [&](const HistoryRow& row) {
      return row.phase == result_.counts.dynamic_phases && is_uncounted(row.energy);
    });
    result_.energy_error = energy_error(result_.energy);
    const auto is_later = [&](const auto& one) {
      return one.load_time == result_.phase_start && one.phase_time > counted_time_;
    };
    std::erase_if(result_.breaks, is_later);
    std::erase_if(result_.bridge_releases, is_later);
    std::erase_if(result_.tooth_falls, is_later);
    if (!result_.breaks.empty()) {
      const fracture::Break& first = result_.breaks.front();
      result_.first_break_time = first.load_time + first.phase_time;
      result_.first_break_load = first.phase_time > 0
                                     ? first_break_reaction_ + applied_load(result_.first_break_time)
                                     : load_at_first_break_;
    }
    if (result_.timings.dynamic > 0) {
      result_.timings.element_updates_per_second = static_cast<double>(subdomain_.n_tetrahedra_global) *
                                                   static_cast<double>(result_.counts.force_evaluations) /
                                                   result_.timings.dynamic;
    }
  }

  /// Saves the partial results of a failed sample, if all ranks can. Collective.
  void keep_what_there_is() {
    if (!control_.failed) return;
    try {
      counted_time_ = infinity;
      // After an allocation failure nothing can be saved.
      parallel::agree(group_, [] { parallel::check_room(room_for_keeping); });
      parallel::together(group_, [&] { finish(); });
      control_.failed(std::move(result_));
    } catch (...) {  // report the first failure
    }
  }

  Stopwatch setup_watch_;
  const parallel::Communicator& group_;
  const input::Parameters& parameters_;
  const geometry::Subdomain& subdomain_;
  const SampleControl& control_;
  const Checkpoint* from_;  // nullptr: from the start
  SampleSetup setup_;
  fracture::BreakableBody& body_ = setup_.body;
  mechanics::BoundaryLoads& loads_ = setup_.loads;
  const mechanics::BoundaryLoads whole_loads_ = loads_;  // before any of them has ended
  const std::unique_ptr<fracture::Criterion>& criterion_ = setup_.criterion;
  const std::unique_ptr<fracture::StressAverage>& average_ = setup_.average;
  PhaseOptions options_;
  EnergyAccount account_;
  HistoryRecorder history_;
  MotionContext context_;
  SampleResult result_;
  std::vector<EndedPhase> ended_;              // breaks and displacements on the root, or from the checkpoint
  double load_at_first_break_ = not_a_number;  // in quasi-static loading [N]
  double first_break_reaction_ = 0;            // of the machine, in a dynamic phase [N]
  double counted_time_ = 0;                    // of the last dynamic phase [s]
  Stopwatch since_save_;
};

/// Runs the sample in the precision of the input, or in double if mixed precision is out of range.
/// Collective.
/// @param from nullptr: from the start
/// @throws CheckpointMismatch on every rank when the checkpoint belongs to a different sample
SampleResult run_in_fitting_precision(const parallel::Communicator& group,
                                      const input::Parameters& parameters,
                                      const geometry::Subdomain& subdomain, const SampleControl& control,
                                      const Checkpoint* from) {
  const auto say = [&](const std::string& line) {
    if (control.log && group.is_root()) control.log(line);
  };
  const bool is_mixed = parameters.time.precision == input::Precision::mixed;
  group.enter("set-up");
  if (from != nullptr && from->engine != parameters.time.engine)
    throw CheckpointMismatch("it was made by another engine");
  if (from == nullptr || from->precision == parameters.time.precision) {
    try {
      return SampleRun(group, parameters, subdomain, control, from).run();
    } catch (const NumberRangeExceeded& error) {
      if (!is_mixed) throw;
      say(fmt::format("{}; the sample is computed again in double", error.what()));
    }
    from = nullptr;
  } else if (is_mixed) {
    say("the sample continues in double: an earlier run left the range of mixed numbers");
  } else {
    throw CheckpointMismatch("it was made in mixed numbers");
  }
  group.enter("set-up");
  input::Parameters in_double = parameters;
  in_double.time.precision = input::Precision::double_;
  SampleResult result = SampleRun(group, in_double, subdomain, control, from).run();
  result.counts.range_restarts = 1;
  return result;
}

/// Runs the sample from its checkpoint, or from the start. Collective.
SampleResult run_from_checkpoint(const parallel::Communicator& group, const input::Parameters& parameters,
                                 const geometry::Subdomain& subdomain, const SampleControl& control) {
  group.enter("restoring");
  parallel::agree(group);
  if (parallel::share(group, !control.checkpoint.empty())) {
    // Every rank has the same checkpoint, so either all reject it or none.
    std::optional<Checkpoint> from;
    try {
      try {
        from = share_checkpoint(group, control.checkpoint);
      } catch (const parallel::AgreedError&) {
        throw;
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

}  // namespace

double arrest_window(const input::Parameters& parameters) {
  if (parameters.time.arrest) return *parameters.time.arrest;
  const double length = *std::ranges::max_element(parameters.specimen.size);
  return length / std::sqrt(parameters.material.youngs_modulus / parameters.material.density);
}

std::string to_string(Outcome outcome) {
  constexpr std::array names{"unbroken", "arrested", "separated", "in one piece", "undecided"};
  return names.at(index(outcome));
}

SampleResult run_sample(const parallel::Communicator& group, const input::Parameters& parameters,
                        const geometry::Subdomain& subdomain, const SampleControl& control) {
  SampleResult result;
  parallel::together(group, [&] { result = run_from_checkpoint(group, parameters, subdomain, control); });
  return result;
}

}  // namespace crackle::dynamics
