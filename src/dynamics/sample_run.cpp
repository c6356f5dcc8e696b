// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/sample_run.h"

#include "common/freed_memory.h"
#include "common/index.h"
#include "common/quantity_text.h"
#include "common/stopwatch.h"
#include "dynamics/checkpoint.h"
#include "dynamics/explicit_phase.h"
#include "dynamics/fragments.h"
#include "dynamics/history.h"
#include "dynamics/machine_load.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_setup.h"
#include "dynamics/separation.h"
#include "fracture/connectivity.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "phase_output.h"
#include "sample_checkpoints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Reports the progress of a dynamic phase on a group's root: by the sample's status line if there is one,
/// otherwise now and then by a line of its log.
class PhaseProgress {
public:
  /// @param control must outlive the object
  /// @param phase number of the phase, from 1
  /// @param duration of the phase [s]
  /// @param first_time since the start of the phase, at which this run begins [s]
  PhaseProgress(const SampleControl& control, std::int64_t phase, double duration, double first_time)
      : control_(&control), phase_(phase), duration_(duration), first_time_(first_time) {}

  /// @param row of the energy account; rows up to the start of this run are left out
  void report(const EnergyRow& row);

private:
  const SampleControl* control_;
  std::int64_t phase_;
  double duration_, first_time_;
  Stopwatch watch_;
  double last_report_ = 0;  // by the stopwatch [s]
};

/// Seconds between two lines of the log.
constexpr double report_interval = 20;

void PhaseProgress::report(const EnergyRow& row) {
  if (!(row.time > first_time_)) return;
  const double seconds = watch_.seconds();
  const bool is_due = seconds >= last_report_ + report_interval;
  const SampleLog& log = control_->progress ? control_->progress : control_->log;
  if (!log || (!control_->progress && !is_due)) return;
  last_report_ = seconds;
  log(fmt::format(
      "dynamic phase {}: {:.0f} %, {:.1f} of {:.1f} us, {} tetrahedra broken, {:.0f} s left at most", phase_,
      100 * row.time / duration_, 1e6 * row.time, 1e6 * duration_, row.broken,
      seconds * (duration_ - row.time) / (row.time - first_time_)));
}

/// Gives owned nodes the input's velocity at the start. Components with a prescribed motion stay at rest:
/// their drive gives them their velocity. Local.
void set_initial_velocity(const MotionContext& context, std::span<const input::BodyLoad> velocities,
                          MotionState& state) {
  const auto v = state.velocity.owned();
  const auto& nodes = context.body->subdomain().nodes;
  for (const input::BodyLoad& load : velocities)
    for (std::size_t n = 0; 3 * n < v.size(); ++n) {
      const Vector velocity = load.at(nodes[n]);
      for (std::size_t c = 0; c < 3; ++c) v[3 * n + c] += velocity[c];
    }
  for (const auto& motion : context.loads->motions)
    for (const auto node : motion.nodes) v[index(node, motion.component)] = 0;
}

/// Memory needed to analyse and write a sample, beyond the sample itself [byte].
constexpr std::size_t room_for_results = std::size_t{64} << 20;

/// Share of the arrest window from which the first break of a dynamic phase is late.
constexpr double late_share = 0.1;

/// A remark on an instability at which a stress hardly exceeds the strength; otherwise empty.
std::string marginal_onset_text(const QuasiStaticLoading& loading, double arrest_window) {
  if (loading.onset_delay() <= late_share * arrest_window) return {};
  return fmt::format(
      "at the onset a stress exceeded the strength by only {:.2g} %, at which a tetrahedron breaks in {}: "
      "the "
      "crack may creep before it runs, the less the smaller fracture.impulse is",
      100 * loading.overload(), quantity_text(loading.onset_delay(), "s"));
}

/// The course of a sample: its phases in chronological order. All members are collective.
class SampleRun {
public:
  SampleRun(const parallel::Communicator& group, const input::Model& model, const input::Output& output,
            const geometry::Subdomain& subdomain, const SampleControl& control, const Checkpoint* from)
      : group_(group),
        model_(model),
        output_(output),
        subdomain_(subdomain),
        control_(control),
        setup_(group, model, subdomain, control.sample, control.more_terms),
        checkpoints_(setup_, control, from),
        account_(group, body_),
        history_(group, body_, loads_, account_, output.probes),
        context_(setup_.motion_context()) {
    result_.stable_step = setup_.stable_step;
    result_.mass_scaling = setup_.mass_scaling;
    result_.wave_transit = wave_transit(model_.specimen.size, setup_.waves);
    result_.load_is_reaction = machine_reacts();
    result_.time_step = setup_.grid.step;
    result_.timings.setup = setup_watch_.seconds();
    say(fmt::format("{} nodes, {} tetrahedra; stable step {:.3g} ns, used {:.4g} ns, {} steps",
                    subdomain.layout.n_global, subdomain.n_tetrahedra_global, 1e9 * result_.stable_step,
                    1e9 * result_.time_step, setup_.grid.n_steps));
    if (result_.mass_scaling) say("mass scaling: " + to_string(*result_.mass_scaling));
  }

  SampleResult run() {
    try {
      // A failure on one rank is thrown on all of them here, after they have saved the partial results
      // together.
      parallel::run_collectively<NumberRangeExceeded, CheckpointMismatch>(group_, [&] {
        if (model_.time.start == input::Start::rest)
          move_from_rest();
        else
          load_until_end();
        if (result_.suspended) return;
        group_.enter("results");
        finish();
      });
    } catch (const parallel::AgreedError&) {
      save_partial_results();
      throw;
    } catch (const NumberRangeExceeded&) {
      save_partial_results();
      throw;
    }
    return std::move(result_);
  }

private:
  void say(const std::string& line) const {
    if (control_.log && group_.is_root()) control_.log(line);
  }

  void move_from_rest() {
    MotionState state = at_rest();
    // Displacements imposed instantaneously, before the body can follow, strain it. Their drive supplies that
    // energy, and whatever set the body in motion its kinetic energy.
    loads_.set_displacements(0, state.displacement.owned());
    set_initial_velocity(context_, model_.initial_velocities(), state);
    parallel::check_peers(group_);
    state.displacement.update_ghosts();
    const double strain =
        strain_energy(group_, body_, state.displacement.local()) + Terms(context_).stored(state.displacement);
    account_.add_phase(strain + kinetic_energy(context_, state), 0);
    say("dynamic phase 1 starts from rest");
    const PhaseResult phase = move(0, {}, state);
    if (phase.suspended) return;
    result_.separated_at = phase.separated_at;
    result_.outcome = !has_broken()     ? Outcome::unbroken
                      : phase.separated ? Outcome::separated
                                        : Outcome::running;
  }

  void load_until_end() {
    const double patience = arrest_window(model_.time, model_.specimen.size, setup_.waves);
    Stopwatch watch;
    group_.enter("quasi-static loading");
    setup_.refuse_free_body();
    QuasiStaticLoading loading(context_, patience, &loads_);
    release_freed_memory();
    loading.load_at_start(account_);
    bool is_at_limit = model_.time.start == input::Start::equilibrium;
    if (!is_at_limit) loading.refuse_overload();
    for (;; is_at_limit = false) {
      const QuasiStaticEnd end = is_at_limit ? QuasiStaticEnd::unstable : load(loading);
      record(loading);
      result_.timings.quasi_static += watch.seconds();
      if (end != QuasiStaticEnd::unstable) return end_loading(end, loading);
      result_.onset_time = loading.time();
      result_.onset_force = loading.load();
      say(fmt::format(
          "{} at t = {:.6f} s, {}, after {} quasi-static breaks and {} static solves with {} "
          "iterations in {:.1f} s; dynamic phase {} starts",
          is_at_limit ? "equilibrium" : "instability", loading.time(), quantity_text(loading.load(), "N"),
          loading.n_breaks(), loading.n_solves(), loading.n_iterations(), result_.timings.quasi_static,
          result_.counts.dynamic_phases + 1));
      marginal_onset_ = is_at_limit ? std::string() : marginal_onset_text(loading, patience);
      if (!marginal_onset_.empty()) say(marginal_onset_);
      MotionState state = at_rest();
      state.displacement.assign(loading.displacement());
      loading.rest();
      release_freed_memory();
      const PhaseResult phase = move(loading.time(), patience, state);
      watch = Stopwatch();
      if (phase.suspended) return;
      result_.separated_at = phase.separated_at;
      if (!phase.arrested) {
        result_.outcome = phase.separated ? Outcome::separated : Outcome::undecided;
        return;
      }
      group_.enter("quasi-static loading");
      account_.add_phase(phase.external_work, phase.dissipated);
      end_time_ = infinity;  // the equilibrium follows from all breaks
      if (!loading.resume(loading.time() + phase.time, phase.kinetic, state.displacement, account_)) {
        result_.outcome = Outcome::separated;
        take_fragments(state.displacement);
        if (std::isnan(result_.separated_at)) result_.separated_at = phase.last_break;
        return;
      }
      result_.separated_at = SampleResult::none;
    }
  }

  /// Quasi-static loading up to the next instability or the end.
  QuasiStaticEnd load(QuasiStaticLoading& loading) {
    std::function<bool()> must_suspend;
    if (control_.stop)
      must_suspend = [&] {
        if (control_.progress && group_.is_root())
          control_.progress(fmt::format("quasi-static loading: {} breaks, {} static solves",
                                        loading.n_breaks(), loading.n_solves()));
        return control_.stop();
      };
    return loading.advance(account_, must_suspend, [&](const LoadState& loads) {
      history_.record_equilibrium(loading.time(), loads, loading.displacement());
    });
  }

  void record(const QuasiStaticLoading& loading) {
    result_.counts.quasi_static_breaks = loading.n_breaks();
    result_.counts.static_solves = loading.n_solves();
    result_.counts.solver_iterations = loading.n_iterations();
    result_.equilibrium_residual = loading.residual();
    load_at_first_break_ = loading.load_at_first_break();
  }

  /// The sample ends, or is suspended, in quasi-static loading.
  void end_loading(QuasiStaticEnd end, const QuasiStaticLoading& loading) {
    if (end == QuasiStaticEnd::suspended) {
      group_.enter("saving");
      if (checkpoints_.is_past_start())
        checkpoints_.save({}, result_.energy, result_.frames, result_.fragment_history);
      result_.suspended = true;
      return;
    }
    result_.outcome = !has_broken() ? Outcome::unbroken
                      : end == QuasiStaticEnd::separated || is_separated(group_, body_, loads_)
                          ? Outcome::separated
                          : Outcome::arrested;
    if (result_.energy.empty())
      result_.energy.push_back(account_.row(0, {.strain = loading.strain_energy()}));
    take_fragments(loading.displacement());
  }

  /// The fragments of a body at rest at the end.
  void take_fragments(const parallel::NodeField& displacement) {
    const auto labels = fracture::piece_labels(group_, body_);
    result_.fragments = find_fragments(group_, body_, labels, {}, displacement.owned(), {});
    const FragmentCount count = count_fragments(group_, body_, labels, {}, 0);
    if (group_.is_root() && result_.fragment_history.empty()) result_.fragment_history.push_back(count);
  }

  /// True if anything has broken.
  bool has_broken() const {
    parallel::check_peers(group_);
    return parallel::any_of_all(group_, !body_.breaks().empty());
  }

  MotionState at_rest() const {
    return {parallel::NodeField(group_, subdomain_.layout), parallel::NodeField(group_, subdomain_.layout)};
  }

  /// The next dynamic phase: computed, or taken from the checkpoint.
  /// @param arrest_window as in PhaseOptions [s]
  PhaseResult move(double load_time, std::optional<double> arrest_window, MotionState& state) {
    group_.enter("dynamic phase");
    result_.phase_start = load_time;
    const std::int64_t number = ++result_.counts.dynamic_phases;
    if (const EndedPhase* ended = checkpoints_.ended(number, load_time)) return replay(*ended, state);
    Stopwatch watch;
    std::unique_ptr<MovingBody> motion;
    PhaseOptions options = phase_options(load_time, arrest_window, motion);
    const double duration = setup_.grid.duration();
    PhaseProgress progress(
        control_, number, duration,
        options.from != nullptr ? static_cast<double>(options.from->running->step) * setup_.grid.step : 0);
    if (group_.is_root()) options.on_row = [&](const EnergyRow& row) { progress.report(row); };
    motion = make_motion(context_, model_.time, load_time, duration, state);
    const ReleasesSince releases(body_);
    PhaseResult phase =
        run_explicit_phase(context_, *motion, setup_.splitting, account_, load_time, options, state);
    result_.timings.dynamic += watch.seconds();
    result_.timings.exchange_cost += motion->exchange_cost();
    result_.suspended = phase.suspended;
    if (phase.suspended) return phase;
    if (phase.arrested && checkpoints_.are_saved())
      checkpoints_.add(
          checkpoints_.gather(phase, load_time, releases, state, history_.rows_of_phase(number)));
    record(phase);
    return phase;
  }

  /// @param motion of the phase, when it is called back
  PhaseOptions phase_options(double load_time, std::optional<double> arrest_window,
                             const std::unique_ptr<MovingBody>& motion) {
    const std::int64_t number = result_.counts.dynamic_phases;
    PhaseOptions options{.grid = setup_.grid,
                         .arrest_window = arrest_window,
                         // Loads that change, and waves, may take their time to break a body in equilibrium.
                         .awaits_break = starts_moving(number),
                         .ends_out_of_range = model_.time.precision == input::Precision::double_,
                         .freezes = model_.time.precision == input::Precision::double_,
                         .n_frames = output_.frames,
                         .history_interval = output_.history,
                         .ending_loads = &loads_,
                         .from = checkpoints_.running(number, load_time)};
    if (model_.time.after_separation > 0) options.after_separation = model_.time.after_separation;
    if (options.from != nullptr) {
      history_.append(options.from->running->history);
      say(fmt::format("dynamic phase {} continues at step {}", number, options.from->running->step));
    }
    if (control_.stop || checkpoints_.are_saved()) {
      options.request = [&] { return checkpoints_.request(); };
      options.save = [&, number](RunningPhase phase, const PhaseResult& so_far) {
        phase.history = history_.rows_of_phase(number);
        checkpoints_.save(std::move(phase), so_far.energy, so_far.frames, so_far.fragment_history);
      };
    }
    // Applied forces are known analytically; only reactions must be recorded.
    if (result_.load_is_reaction && !has_broken()) {
      options.on_first_break = [&](double time, const MotionState& now) {
        LoadState loads = motion->measure(time, now);
        for (ConditionState& condition : loads.conditions) {
          condition.applied = {};
          condition.amplitude = 0;
        }
        checkpoints_.first_break_reaction = machine_load(loads_, loads).force;
      };
    }
    options.kinks = kinks(load_time, load_time + setup_.grid.duration());
    for (double& kink : options.kinks) kink -= load_time;
    options.on_history = [&, number, load_time](const EnergyRow& row, const MotionState& now,
                                                bool is_output) {
      history_.record_motion(number, load_time, row, now.displacement, now.velocity,
                             motion->measure(load_time + row.time, now), is_output);
    };
    options.on_failure = [&](PhaseResult partial) {
      result_.energy = std::move(partial.energy);
      result_.frames = std::move(partial.frames);
      result_.fragment_history = std::move(partial.fragment_history);
    };
    return options;
  }

  void record(PhaseResult& phase) {
    result_.counts.steps += phase.n_steps;
    result_.counts.force_evaluations += phase.n_forces;
    result_.energy = std::move(phase.energy);
    result_.frames = std::move(phase.frames);
    result_.fragments = std::move(phase.fragments);
    result_.fragment_history = std::move(phase.fragment_history);
    result_.note = phase.note;
    end_time_ = phase.end_time;
    if (phase.arrested) note_early_arrest(phase);
    say(fmt::format("dynamic phase {}: {} after {:.1f} us, {} tetrahedra broken so far",
                    result_.counts.dynamic_phases,
                    phase.arrested    ? result_.energy.back().broken == 0 ? "nothing broke" : "arrested"
                    : phase.separated ? "the body is apart"
                                      : "complete",
                    1e6 * phase.time, result_.energy.back().broken));
    if (result_.note.empty() && !phase.arrested && phase.time > phase.end_time)
      result_.note = fmt::format(
          "cracks were still running at time.duration = {:.4g} us, and the results end there (the body {} at "
          "{:.4g} us): "
          "increase time.duration",
          1e6 * phase.end_time, phase.separated ? "had come apart" : "was still in one piece",
          1e6 * phase.time);
    if (!result_.note.empty()) say(result_.note);
  }

  /// True for the dynamic phase in which the loads set an equilibrium in motion.
  bool starts_moving(std::int64_t phase) const {
    return model_.time.start == input::Start::equilibrium && phase == 1;
  }

  /// Arrest is the rule between quasi-static loading, but ends the motion of a body that started with it.
  void note_early_arrest(const PhaseResult& phase) {
    const double duration = setup_.grid.duration();
    if (!starts_moving(result_.counts.dynamic_phases) || phase.time >= duration) return;
    early_arrest_ = fmt::format(
        "arrest ended the motion {:.4g} us after the start, before time.duration, {:.4g} us: nothing had "
        "broken for {:.4g} us; to go on, raise time.arrest",
        1e6 * phase.time, 1e6 * duration,
        1e6 * arrest_window(model_.time, model_.specimen.size, setup_.waves));
    if (result_.note.empty()) result_.note = early_arrest_;
  }

  /// Restores an arrested phase computed by an earlier run.
  PhaseResult replay(const EndedPhase& ended, MotionState& state) {
    say(fmt::format("dynamic phase {} is taken from the checkpoint", result_.counts.dynamic_phases));
    const Checkpoint& checkpoint = checkpoints_.restore(ended, state);
    history_.append(ended.history);
    result_.energy = checkpoint.energy;
    result_.frames = checkpoint.frames;
    result_.fragment_history = checkpoint.fragment_history;
    result_.counts.steps += ended.n_steps;
    result_.counts.force_evaluations += ended.n_forces;
    end_time_ = std::min(ended.time, setup_.grid.duration());
    PhaseResult phase;
    phase.arrested = true;
    phase.time = ended.time;
    phase.kinetic = ended.kinetic;
    phase.external_work = ended.external_work;
    phase.dissipated = ended.dissipated;
    phase.separated_at = ended.separated_at;
    phase.last_break = ended.last_break;
    note_early_arrest(phase);
    return phase;
  }

  /// True if the machine's load is, at least in part, a reaction.
  bool machine_reacts() const {
    return std::ranges::any_of(loads_.governing, [&](const mechanics::GoverningCondition& governing) {
      const auto is_governing = [&](const auto& one) { return one.condition == governing.condition; };
      return index(governing.condition) >= loads_.conditions.size() ||  // a tool
             std::ranges::any_of(loads_.motions, is_governing) ||
             std::ranges::any_of(loads_.absorbers, is_governing);
    });
  }

  /// The machine's load without reactions [N].
  double applied_load(double time) const {
    LoadState state;
    apply_loads(whole_loads_, time, state);
    return machine_load(whole_loads_, state).force;
  }

  /// Load times at which any load or prescribed motion turns, after `from` and up to `to`, ascending [s].
  std::vector<double> kinks(double from, double to) const {
    std::set<double> times;
    const auto add = [&](const auto& load) {
      for (const auto& [time, factor] : load.history)
        if (time > from && time <= to) times.insert(time);
    };
    std::ranges::for_each(model_.boundaries, add);
    std::ranges::for_each(model_.loads, add);
    std::ranges::for_each(model_.tools, add);
    return {times.begin(), times.end()};
  }

  /// Takes the machine's results from all moments, and leaves the rows of the output.
  void finish_history() {
    result_.loads = load_results(result_);
    // Applied loads are known between the steps, too.
    if (!result_.load_is_reaction)
      for (const auto& [from, to] : dynamic_intervals(result_))
        for (const double time : kinks(from, to))
          if (const double load = applied_load(time); load > result_.loads.peak_load) {
            result_.loads.peak_load = load;
            result_.loads.displacement_at_peak = load_displacement_at(result_.history, time);
          }
    std::erase_if(result_.history, [](const HistoryRow& row) { return !row.is_output; });
    if (loads_.governing.empty())  // stress from the start alone: there is no machine
      result_.onset_force = result_.loads.peak_load = result_.loads.displacement_at_peak = not_a_number;
  }

  /// Appends to the sample's note.
  void note(const std::string& text) {
    if (!text.empty()) result_.note += (result_.note.empty() ? "" : "; ") + text;
  }

  /// Notes the tools that never came to the body.
  void note_idle_tools() {
    const std::vector<HistoryRow>& rows = result_.history;
    for (std::size_t i = 0; !rows.empty() && i < model_.tools.size(); ++i) {
      const auto is_idle = [&](const HistoryRow& row) {
        return row.tools[i].reaction == Vector{} && row.tools[i].velocity == rows.front().tools[i].velocity;
      };
      if (std::ranges::all_of(rows, is_idle))
        note(fmt::format("{} never touched the body", input::name_of(model_.tools[i], i)));
    }
  }

  void finish() {
    if (result_.note.empty()) result_.note = early_arrest_;
    note(marginal_onset_);
    result_.breaks = gather_breaks(group_, body_.breaks());
    result_.bridge_releases = gather_bridge_releases(group_, body_.bridge_releases());
    result_.stiffness_reductions = gather_stiffness_reductions(group_, body_.stiffness_reductions());
    result_.history = history_.rows();
    truncate_results(result_, end_time_);
    note_idle_tools();
    finish_history();
    result_.energy_error = energy_error(result_.energy);
    if (!result_.breaks.empty()) {
      const fracture::Break& first = result_.breaks.front();
      result_.first_break_time = first.load_time + first.phase_time;
      result_.first_break_load =
          first.phase_time > 0 ? checkpoints_.first_break_reaction + applied_load(result_.first_break_time)
                               : load_at_first_break_;
      if (loads_.governing.empty()) result_.first_break_load = not_a_number;
    }
    if (result_.timings.dynamic > 0) {
      result_.timings.element_updates_per_second = static_cast<double>(subdomain_.n_tetrahedra_global) *
                                                   static_cast<double>(result_.counts.force_evaluations) /
                                                   result_.timings.dynamic;
    }
  }

  /// Saves the partial results of a failed sample, if all ranks can.
  void save_partial_results() {
    if (!control_.failed) return;
    try {
      end_time_ = infinity;
      // After an allocation failure nothing can be saved.
      parallel::agree(group_, [] { parallel::check_room(room_for_results); });
      parallel::run_collectively(group_, [&] { finish(); });
      control_.failed(std::move(result_));
    } catch (...) {  // report the first failure
    }
  }

  Stopwatch setup_watch_;
  const parallel::Communicator& group_;
  const input::Model& model_;
  const input::Output& output_;
  const geometry::Subdomain& subdomain_;
  const SampleControl& control_;
  SampleSetup setup_;
  fracture::BreakableBody& body_ = setup_.body;
  mechanics::Conditions& loads_ = setup_.loads;
  const mechanics::Conditions whole_loads_ = loads_;  // before any of them has ended
  SampleCheckpoints checkpoints_;
  EnergyAccount account_;
  HistoryRecorder history_;
  MotionContext context_;
  SampleResult result_;
  double load_at_first_break_ = not_a_number;  // in quasi-static loading [N]
  double end_time_ = 0;                        // of the last dynamic phase [s]
  std::string early_arrest_;                   // the remark on it, if any
  std::string marginal_onset_;                 // that on the last onset, if any
};

/// Runs the sample in the precision of the input, or in double if mixed precision is out of range.
/// Collective.
/// @param from nullptr: from the start
/// @throws CheckpointMismatch on every rank when the checkpoint belongs to a different sample
SampleResult run_in_fitting_precision(const parallel::Communicator& group, const input::Model& model,
                                      const input::Output& output, const geometry::Subdomain& subdomain,
                                      const SampleControl& control, const Checkpoint* from) {
  const auto say = [&](const std::string& line) {
    if (control.log && group.is_root()) control.log(line);
  };
  const bool is_mixed = model.time.precision == input::Precision::mixed;
  group.enter("set-up");
  if (from != nullptr && from->engine != model.time.engine)
    throw CheckpointMismatch("it was made by another engine");
  if (from == nullptr || from->precision == model.time.precision) {
    try {
      return SampleRun(group, model, output, subdomain, control, from).run();
    } catch (const NumberRangeExceeded& error) {
      if (!is_mixed) throw;
      say(fmt::format("{}; the sample is computed again with time.precision = \"double\"", error.what()));
    }
    from = nullptr;
  } else if (is_mixed) {
    say("the sample continues with time.precision = \"double\", because an earlier run exceeded the range of "
        "\"mixed\"");
  } else {
    throw CheckpointMismatch("it was made in mixed numbers");
  }
  group.enter("set-up");
  input::Model in_double = model;
  in_double.time.precision = input::Precision::double_;
  SampleResult result = SampleRun(group, in_double, output, subdomain, control, from).run();
  result.counts.range_restarts = 1;
  return result;
}

/// Runs the sample from its checkpoint, or from the start. Collective.
SampleResult run_from_checkpoint(const parallel::Communicator& group, const input::Model& model,
                                 const input::Output& output, const geometry::Subdomain& subdomain,
                                 const SampleControl& control) {
  group.enter("restoring");
  parallel::check_peers(group);
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
      return run_in_fitting_precision(group, model, output, subdomain, control, &*from);
    } catch (const CheckpointMismatch& mismatch) {
      if (control.log && group.is_root())
        control.log(fmt::format("the checkpoint is not used: {}", mismatch.what()));
    }
  }
  return run_in_fitting_precision(group, model, output, subdomain, control, nullptr);
}

}  // namespace

double arrest_window(const input::Time& time, const Vector& size, const fracture::BodyWaves& waves) {
  return time.arrest ? *time.arrest : std::ranges::max(size) / waves.bar;
}

double wave_transit(const Vector& size, const fracture::BodyWaves& waves) {
  return std::ranges::max(size) / waves.dilatational;
}

SampleResult run_sample(const parallel::Communicator& group, const input::Model& model,
                        const input::Output& output, const geometry::Subdomain& subdomain,
                        const SampleControl& control) {
  SampleResult result;
  parallel::run_collectively(group,
                             [&] { result = run_from_checkpoint(group, model, output, subdomain, control); });
  return result;
}

}  // namespace crackle::dynamics
