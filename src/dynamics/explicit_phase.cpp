// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/explicit_phase.h"

#include "crackle/dynamics/breaking_check.h"
#include "crackle/dynamics/separation.h"
#include "crackle/fracture/connectivity.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/exact_sum.h"

#include "loose_loads.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::dynamics {

namespace {

/// Share of the energy at the strength: far above rounding errors in a hardly loaded body.
constexpr double negligible_share = 1e-12;
/// Maximum number of checks for separation in a phase.
constexpr std::int64_t looks_for_separation = 100;

/// Holds a failure on this rank until the next poll, so that no rank waits for one that has left the step.
class StepFailure {
public:
  explicit StepFailure(const parallel::Communicator& group) : group_(&group) {}
  /// Local work; skipped after a failure.
  template <class Work>
  void guard(const Work& work) {
    if (!error_) guard_messages(work);
  }
  /// Work with communication: runs even after a failure, to avoid deadlock.
  template <class Work>
  void guard_messages(const Work& work) {
    try {
      work();
    } catch (...) {
      if (!error_) error_ = parallel::current_error(*group_);
    }
  }
  const std::optional<std::string>& error() const { return error_; }

private:
  const parallel::Communicator* group_;
  std::optional<std::string> error_;
};

double kinetic_energy(const MotionContext& context, const MotionState& state) {
  const auto v = state.velocity.owned();
  const auto& mass = context.body->operators().node_mass;
  std::vector<double> terms(mass.size());
  for (std::size_t n = 0; n < mass.size(); ++n) {
    terms[n] =
        0.5 * mass[n] * (v[3 * n] * v[3 * n] + v[3 * n + 1] * v[3 * n + 1] + v[3 * n + 2] * v[3 * n + 2]);
  }
  return parallel::exact_sum(*context.group, terms);
}

Frame make_frame(const MotionContext& context, const MotionState& state, double time, std::int64_t n_broken) {
  const auto to_float = [](const std::vector<double>& values) {
    std::vector<float> result(values.size());
    std::ranges::transform(values, result.begin(), [](double value) { return static_cast<float>(value); });
    return result;
  };
  Frame frame{time, {}, {}, n_broken};
  frame.displacement = to_float(
      parallel::gather_nodes(*context.group, context.body->subdomain().layout, state.displacement.owned()));
  frame.velocity = to_float(
      parallel::gather_nodes(*context.group, context.body->subdomain().layout, state.velocity.owned()));
  return frame;
}

/// The share of its stiffness that a breaking tetrahedron keeps in the coming step: the mean over the step of
/// a linear fall.
class GradualRelease {
public:
  GradualRelease(double duration, double step) : duration_(duration), step_(step) {}
  /// @param elapsed since the break [s]
  double remaining(double elapsed) const {
    return duration_ > 0 ? std::max(0.0, 1 - (elapsed + step_ / 2) / duration_) : 0;
  }

private:
  double duration_, step_;  // [s]
};

/// Restores body, criterion and motion to the state of the checkpoint's running phase.
void restore(const Checkpoint& checkpoint, const GradualRelease& release, double time,
             fracture::BreakableBody& body, fracture::Criterion& criterion, MovingBody& motion) {
  const std::size_t n_changes = body.changes().size();
  body.restore(checkpoint.running->releases,
               [&](double broke_at) { return release.remaining(time - broke_at); });
  fracture::update_strengths(criterion, body, body.changes().subspan(n_changes));
  restore_memory(checkpoint.memory, body.subdomain(), criterion);
  motion.release(body.changes().subspan(n_changes));
  motion.restore(checkpoint.running->motion);
}

/// Ends the loads on fragments that have come loose. Collective.
/// @param state re-read if there are any
void end_loose_loads(const MotionContext& context, MovingBody& motion, double time,
                     const std::vector<std::int64_t>& labels, mechanics::BoundaryLoads& loads,
                     MotionState& state) {
  const auto nodes = nodes_of_loose_pieces(*context.group, *context.body, loads, labels);
  if (!nodes) return;
  motion.read(state);
  motion.end_loads(time, *nodes, state);
  loads.end_loads(*context.group, *nodes);
}

/// Why the motion is no longer valid, agreed on every rank: the reason of the lowest rank that has one.
/// Collective.
/// @param local this rank's reason
std::optional<std::string> agreed_failure(const parallel::Communicator& group,
                                          const std::optional<std::string>& local) {
  try {
    parallel::agree_on_error(group, local);
  } catch (const parallel::AgreedError& error) {
    return error.what();
  }
  return std::nullopt;
}

/// The steps after which a frame is stored; step 0 is the start.
std::vector<std::int64_t> frame_steps(int n_frames, std::int64_t n_steps) {
  std::vector<std::int64_t> steps;
  for (int k = 0; k < n_frames; ++k) {
    steps.push_back(n_frames == 1 ? n_steps : (n_steps * k + (n_frames - 1) / 2) / (n_frames - 1));
  }
  return steps;
}

/// @param result partially filled when this throws
void run_phase(const MotionContext& context, MovingBody& motion, const Splitting& splitting,
               const EnergyAccount& account, double load_time, const PhaseOptions& options,
               MotionState& state, PhaseResult& result) {
  const parallel::Communicator& group = *context.group;
  fracture::BreakableBody& body = *context.body;
  fracture::Criterion& criterion = *context.criterion;
  const double dt = options.grid.step;
  const std::int64_t n_steps = options.grid.n_steps;
  const std::int64_t last_step = options.arrest_window ? max_phase_durations * n_steps : n_steps;
  const std::int64_t row_interval = std::max<std::int64_t>(1, n_steps / options.n_energy_rows);
  const std::int64_t history_interval =
      options.history_interval ? std::max<std::int64_t>(1, std::llround(*options.history_interval / dt))
                               : row_interval;
  const auto pictures = frame_steps(options.n_frames, n_steps);

  const double negligible = negligible_share * energy_at_strength(group, body, criterion.strengths());

  const auto is_picture = [&](std::int64_t step) { return std::ranges::binary_search(pictures, step); };
  const auto is_energy_row = [&](std::int64_t step) {
    return step % row_interval == 0 || step >= n_steps || is_picture(step);
  };
  const auto is_history_row = [&](std::int64_t step) {
    return options.on_history && (step % history_interval == 0 || step >= n_steps);
  };
  const auto has_output = [&](std::int64_t step) {
    return step <= n_steps && (is_energy_row(step) || is_history_row(step));
  };
  // The steps communicate without further agreement on errors.
  const auto begin_steps = [&] {
    group.enter("time steps");
    parallel::agree(group);
  };
  const auto write_outputs = [&](std::int64_t step, bool is_last = false) {
    group.enter("energy row");
    const double time = static_cast<double>(step) * dt;
    motion.read(state);
    const double work = motion.external_work(load_time + time, state);
    const EnergyRow row = account.row(time, {.kinetic = kinetic_energy(context, state),
                                             .strain = strain_energy(group, body, state.displacement.local()),
                                             .work = work,
                                             .dissipated = motion.dissipated_energy()});
    if (options.on_history && (is_last || is_history_row(step))) {
      group.enter("history");
      options.on_history(row, state);
    }
    if (!is_last && !is_energy_row(step)) return begin_steps();
    result.energy.push_back(row);
    // The rows are equal on every rank.
    if (const auto fault =
            energy_fault(result.energy, static_cast<std::size_t>(options.n_energy_rows), negligible))
      throw std::runtime_error(*fault);
    if (options.on_row) options.on_row(result.energy.back());
    if (is_picture(step)) {
      group.enter("frame");
      Frame frame = make_frame(context, state, time, result.energy.back().broken);
      if (group.is_root()) result.frames.push_back(std::move(frame));
    }
    begin_steps();
  };

  const auto breaking_check = make_breaking_check(context, motion);
  const GradualRelease gradual_release(options.release_time, dt);
  const ReleasesSince releases(body);
  std::int64_t last_break = 0;
  Separation separation;
  std::optional<LoadWatch> load_watch;
  if (options.ending_loads != nullptr) load_watch.emplace(body, *options.ending_loads, n_steps);
  std::int64_t step = 0;
  if (options.from != nullptr) {
    group.enter("restoring");
    parallel::agree(group, [&] {
      restore(*options.from, gradual_release, static_cast<double>(options.from->running->step) * dt, body,
              criterion, motion);
    });
    if (context.vicinity != nullptr) {
      const auto weakened = context.vicinity->update(group);
      motion.update_strengths(weakened);
      if (context.average != nullptr) context.average->forget(weakened);
    }
    last_break = options.from->running->last_break;
    separation = options.from->running->separation;
    step = options.from->running->step;
    if (load_watch) {
      load_watch->restore(options.from->running->load_look);
      restore_ended_loads(group, body.subdomain().layout, options.from->running->ended_loads,
                          *options.ending_loads);
    }
    result.energy = options.from->energy;
    result.frames = options.from->frames;
    motion.read(state);
    begin_steps();
  } else {
    write_outputs(0);
  }
  bool awaits_first_break = options.on_first_break && last_break == 0;
  StepFailure step_failure(group);
  step_failure.guard([&] { breaking_check->start(); });
  std::vector<std::int32_t> breaking;
  bool ends = false;
  while (!ends) {
    step_failure.guard_messages([&] {
      motion.step(step % 2 == 0 ? splitting.even : splitting.odd, dt,
                  load_time + static_cast<double>(step) * dt);
    });
    ++step;
    const std::size_t n_changes = body.changes().size();
    breaking.clear();
    step_failure.guard_messages([&] {
      const auto found = breaking_check->end_step(step);
      breaking.assign(found.begin(), found.end());
    });
    if (awaits_first_break && parallel::any_of_all(group, !breaking.empty())) {
      awaits_first_break = false;
      parallel::agree_on_error(group, step_failure.error());
      motion.read(state);
      options.on_first_break(load_time + static_cast<double>(step) * dt, state);
      begin_steps();
    }
    step_failure.guard([&] {
      const double time = static_cast<double>(step) * dt;
      if (body.is_releasing())
        body.continue_releases([&](double broke_at) { return gradual_release.remaining(time - broke_at); },
                               [&](std::int32_t t) { return motion.strain(t); });
      for (const auto t : breaking)
        body.release(t, motion.strain(t), load_time, time, gradual_release.remaining(0));
    });
    step_failure.guard_messages([&] {
      body.release_bridges(group, load_time, static_cast<double>(step) * dt,
                           [&](std::int32_t t) { return motion.strain(t); });
    });
    if (const auto changes = body.changes().subspan(n_changes); !changes.empty()) {
      step_failure.guard([&] {
        fracture::update_strengths(criterion, body, changes);
        motion.release(changes);
        if (load_watch) load_watch->note(changes, step);
      });
      last_break = step;
    }
    if (context.vicinity != nullptr)
      step_failure.guard_messages([&] {
        const auto weakened = context.vicinity->update(group);
        motion.update_strengths(weakened);
        if (context.average != nullptr) context.average->forget(weakened);
      });
    std::optional<std::vector<std::int64_t>> labels;  // of the current pieces, when needed
    if (load_watch && load_watch->is_due(step)) {
      parallel::agree_on_error(group, step_failure.error());
      if (load_watch->must_look(group, step, last_break)) {
        group.enter("loads on fragments");
        labels = fracture::piece_labels(group, body);
        end_loose_loads(context, motion, load_time + static_cast<double>(step) * dt, *labels,
                        *options.ending_loads, state);
        begin_steps();
      }
    }
    auto request = Request::go_on;
    std::int64_t requested = 0;
    const bool may_save = step % steps_per_poll == 0;
    const bool is_poll = may_save || step == n_steps || step == last_step;
    // Check before computing energies from numbers that may be out of range.
    if (is_poll || has_output(step)) {
      std::optional<std::string> local_failure;
      step_failure.guard([&] {
        local_failure = motion.failure();
        if (may_save && options.request) requested = static_cast<std::int64_t>(options.request());
      });
      parallel::agree_on_error(group, step_failure.error());
      if (const auto failure = agreed_failure(group, local_failure)) {
        const std::string when = fmt::format("{} ({:.4g} us after the start of the phase)", *failure,
                                             1e6 * static_cast<double>(step) * dt);
        // All data since the last output are invalid, and a body that was intact then has no fragments.
        if (!options.ends_out_of_range || result.energy.back().broken == 0 ||
            !is_separated(group, body, *context.loads))
          throw NumberRangeExceeded(when);
        result.separated = true;
        if (is_unloaded(group, body, *context.loads)) result.separated_at = result.energy.back().time;
        result.note = fmt::format("the phase ended early, with the body apart: {}", when);
        result.counted_time = result.energy.back().time;
        break;
      }
    }
    if (is_poll) {
      std::array<std::int64_t, 2> poll{last_break, requested};
      parallel::all_reduce(group, poll, MPI_MAX);
      last_break = poll[0];
      request = static_cast<Request>(poll[1]);
      result.arrested =
          options.arrest_window && static_cast<double>(step - last_break) * dt >= *options.arrest_window;
      const bool is_over = step >= n_steps;
      const std::int64_t pause = is_over ? 0 : n_steps / looks_for_separation;
      const bool is_known = separation.found && separation.unloaded;
      if (!result.arrested && !is_known && last_break > separation.looked_at &&
          step >= separation.looked_at + pause) {
        separation.looked_at = step;
        if (!labels) labels = fracture::piece_labels(group, body);
        if (!separation.found && is_separated(group, body, *context.loads, *labels)) separation.found = step;
        // Conditions separated by edges are also separated by faces.
        if (!separation.unloaded && is_unloaded(group, body, *context.loads))
          separation.unloaded = last_break;
        begin_steps();
      }
      result.separated = separation.found.has_value();
      ends = result.arrested || step >= last_step ||
             (is_over && (result.separated || !options.arrest_window)) ||
             (result.separated && options.after_separation &&
              static_cast<double>(step - *separation.found) * dt >= *options.after_separation);
    }
    if (has_output(step) || (ends && (step <= n_steps || result.arrested))) write_outputs(step, ends);
    if (request == Request::go_on || ends) continue;
    group.enter("saving");
    RunningPhase running{load_time, step, last_break, separation, releases.gather(group), motion.save()};
    if (load_watch) {
      parallel::agree(group);
      running.load_look = load_watch->state(group);
      running.ended_loads = gather_ended_loads(group, body.subdomain().layout, *options.ending_loads);
    }
    options.save(std::move(running), result.energy, result.frames);
    if (request == Request::park) {
      result.parked = true;
      return;
    }
    begin_steps();
  }
  result.time = static_cast<double>(step) * dt;
  result.last_break = static_cast<double>(last_break) * dt;
  if (separation.unloaded) result.separated_at = static_cast<double>(*separation.unloaded) * dt;
  if (result.note.empty()) result.counted_time = static_cast<double>(std::min(step, n_steps)) * dt;
  result.n_steps = step;
  result.n_forces = motion.n_forces();
  result.kinetic = result.energy.back().kinetic;
  if (result.arrested) {
    result.external_work = motion.external_work(load_time + result.time, state);
    result.dissipated = motion.dissipated_energy();
  }
}

}  // namespace

PhaseResult run_explicit_phase(const MotionContext& context, MovingBody& motion, const Splitting& splitting,
                               const EnergyAccount& account, double load_time, const PhaseOptions& options,
                               MotionState& state) {
  PhaseResult result;
  try {
    run_phase(context, motion, splitting, account, load_time, options, state, result);
  } catch (...) {
    if (options.on_failure) options.on_failure(std::move(result));
    throw;
  }
  return result;
}

}  // namespace crackle::dynamics
