// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/explicit_phase.h"

#include "common/index.h"
#include "dynamics/breaking_check.h"
#include "dynamics/separation.h"
#include "fracture/connectivity.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include "break_release.h"
#include "loose_loads.h"
#include "phase_end.h"
#include "phase_output.h"
#include "step_failure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <utility>

namespace crackle::dynamics {

namespace {

/// The reason of the lowest rank that has one, on every rank; empty if none has. Collective.
/// @param own this rank's reason
std::optional<std::string> agreed_reason(const parallel::Communicator& group,
                                         const std::optional<std::string>& own) {
  try {
    parallel::agree_on_error(group, own);
  } catch (const parallel::AgreedError& error) {
    return error.what();
  }
  return std::nullopt;
}

/// One dynamic phase. All members are collective.
class ExplicitPhase {
public:
  /// @param result partially filled when a member throws
  ExplicitPhase(const MotionContext& context, MovingBody& motion, const Splitting& splitting,
                const EnergyAccount& account, double load_time, const PhaseOptions& options,
                MotionState& state, PhaseResult& result)
      : context_(context),
        group_(*context.group),
        body_(*context.body),
        motion_(motion),
        splitting_(splitting),
        load_time_(load_time),
        options_(options),
        state_(state),
        result_(result),
        output_(context, motion, account, load_time, options, state, result),
        end_(context, options),
        releases_(body_),
        breaking_check_(make_breaking_check(context, motion)),
        break_release_(context, motion, load_time),
        failure_(group_) {
    if (options.ending_loads != nullptr)
      load_watch_.emplace(body_, *options.ending_loads, options.grid.n_steps);
  }

  void run() {
    if (options_.from != nullptr)
      restore(*options_.from);
    else
      output_.write(0, false);
    begin_steps();
    awaits_first_break_ = options_.on_first_break && last_break_ == 0;
    failure_.guard([&] { breaking_check_->start(); });
    while (!ends_) {
      advance();
      if (result_.suspended) return;
    }
    finish();
  }

private:
  /// One step and all that may follow it.
  void advance() {
    // Move: the stages' kicks and drifts, with the exchange of ghost displacements.
    failure_.guard_messages([&] {
      motion_.step(step_ % 2 == 0 ? splitting_.even : splitting_.odd, options_.grid.step, load_time());
    });
    ++step_;
    pieces_.reset();

    // Break: find the tetrahedra that break, and release them.
    find_breaking();
    if (awaits_first_break_) record_first_break();
    release_breaking();

    // Loads end on fragments that have come loose.
    if (load_watch_ && load_watch_->is_due(step_)) end_loose_loads();

    // Failures are agreed on before energies are computed from numbers that may be out of range.
    const bool may_save = step_ % steps_per_poll == 0;
    const bool is_poll = may_save || step_ == options_.grid.n_steps || step_ == end_.last_step();
    const bool is_output = output_.is_due(step_);
    if (!is_poll && !is_output) return;
    if (is_poll && options_.freezes && result_.energy.back().broken > 0) freeze_leaving();
    const Request own_request = agree_on_failures(may_save);
    if (ends_) return;

    // Arrest and separation, from what all ranks know.
    Request request = Request::go_on;
    if (is_poll) {
      request = exchange(own_request);
      check_end();
    }

    // Energy account, history and frames.
    if (is_output || (ends_ && (step_ <= options_.grid.n_steps || result_.arrested))) {
      output_.write(step_, ends_);
      begin_steps();
    }

    // Save, and leave if asked to.
    if (request == Request::go_on || ends_) return;
    save();
    if (request == Request::suspend)
      result_.suspended = true;
    else
      begin_steps();
  }

  /// Time of the load curves now [s].
  double load_time() const { return load_time_ + phase_time(); }
  /// Time since the start of the phase [s].
  double phase_time() const { return time_of(step_); }
  double time_of(std::int64_t step) const { return static_cast<double>(step) * options_.grid.step; }

  /// The steps communicate without further agreement on errors.
  void begin_steps() {
    group_.enter("time steps");
    parallel::check_peers(group_);
  }

  void find_breaking() {
    breaking_.clear();
    failure_.guard_messages([&] {
      const auto found = breaking_check_->end_step(step_);
      breaking_.assign(found.begin(), found.end());
      const auto frozen = motion_.frozen();
      if (!frozen.empty())
        std::erase_if(breaking_, [&](std::int32_t t) {
          return frozen[index(body_.subdomain().tetrahedra[index(t)][0])] != 0;
        });
    });
  }

  void record_first_break() {
    if (!parallel::any_of_all(group_, !breaking_.empty())) return;
    awaits_first_break_ = false;
    failure_.agree();
    motion_.read(state_);
    options_.on_first_break(load_time(), state_);
    begin_steps();
  }

  void release_breaking() {
    const auto changes = break_release_.apply(breaking_, phase_time(), failure_);
    if (changes.empty()) return;
    failure_.guard([&] {
      if (load_watch_) load_watch_->note(changes, step_);
      end_.note(changes);
    });
    last_break_ = step_;
  }

  /// Labels of the current pieces.
  const std::vector<std::int64_t>& pieces() {
    if (!pieces_) pieces_ = fracture::piece_labels(group_, body_);
    return *pieces_;
  }

  void end_loose_loads() {
    failure_.agree();
    if (!load_watch_->must_check(group_, step_, last_break_)) return;
    group_.enter("loads on fragments");
    mechanics::Conditions& loads = *options_.ending_loads;
    if (const auto nodes = nodes_of_loose_pieces(group_, body_, loads, pieces())) {
      motion_.read(state_);
      motion_.end_loads(load_time(), *nodes, state_);
      loads.end_loads(group_, *nodes);
      end_.note_new_conditions();
    }
    begin_steps();
  }

  /// Freezes loose pieces whose numbers are about to leave their range: they fly on without being computed.
  void freeze_leaving() {
    std::vector<std::int32_t> leaving;
    failure_.guard([&] { leaving = motion_.leaving(); });
    failure_.agree();
    if (!parallel::any_of_all(group_, !leaving.empty())) return;
    group_.enter("fragments that leave");
    const auto nodes = nodes_of_loose_pieces_at(group_, body_, *context_.loads, pieces(), leaving);
    motion_.read(state_);
    const auto energies = parallel::agree(group_, [&] {
      const std::vector<double> of_node = kinetic_energies(context_, state_);
      std::vector<double> terms;
      for (const auto node : nodes)
        if (index(node) < of_node.size()) terms.push_back(of_node[index(node)]);
      return terms;
    });
    const double energy = parallel::exact_sum(group_, energies);
    parallel::agree(group_, [&] { motion_.freeze(nodes, energy); });
    begin_steps();
  }

  /// Throws failures since the last time, and ends the phase if the motion is no longer valid.
  /// @return this rank's request, if it may save now
  Request agree_on_failures(bool may_save) {
    std::optional<std::string> invalid;
    Request request = Request::go_on;
    failure_.guard([&] {
      invalid = motion_.failure();
      if (may_save && options_.request) request = options_.request();
    });
    failure_.agree();
    if (const auto reason = agreed_reason(group_, invalid))
      end_invalid(fmt::format("{} ({:.4g} us after the start of the phase)", *reason, 1e6 * phase_time()));
    return request;
  }

  /// @param reason why the motion is no longer valid
  /// @throws NumberRangeExceeded unless the phase may end like this
  void end_invalid(const std::string& reason) {
    const EnergyRow& last = result_.energy.back();
    // All data since the last output are invalid, and a body that was intact then has no fragments.
    if (!options_.ends_out_of_range || last.broken == 0 ||
        !is_separated(group_, body_, *context_.loads, pieces()))
      throw NumberRangeExceeded(reason);
    result_.separated = true;
    if (is_unloaded(group_, body_, *context_.loads, pieces())) result_.separated_at = last.time;
    result_.note = fmt::format("the phase ended early, after the body had separated: {}", reason);
    result_.end_time = last.time;
    output_.write_last_fragments();
    ends_ = true;
  }

  /// The last break on any rank, and the strongest request.
  Request exchange(Request own) {
    std::array<std::int64_t, 2> most{last_break_, static_cast<std::int64_t>(own)};
    parallel::all_reduce(group_, most, MPI_MAX);
    last_break_ = most[0];
    return static_cast<Request>(most[1]);
  }

  void check_end() {
    if (end_.must_check_separation(step_, last_break_)) {
      end_.check_separation(
          step_, last_break_, [this]() -> const auto& { return pieces(); });
      begin_steps();
    }
    result_.arrested = end_.is_arrested(step_, last_break_);
    result_.separated = end_.separation().found.has_value();
    ends_ = end_.is_reached(step_, last_break_);
  }

  void save() {
    group_.enter("saving");
    RunningPhase running{load_time_,    step_, last_break_, end_.separation(), releases_.gather(group_),
                         motion_.save()};
    if (load_watch_) {
      parallel::check_peers(group_);
      running.load_check = load_watch_->state(group_);
      running.ended_loads = gather_ended_loads(group_, body_.subdomain().layout, *options_.ending_loads);
    }
    options_.save(std::move(running), result_);
  }

  void restore(const Checkpoint& checkpoint) {
    const RunningPhase& running = *checkpoint.running;
    group_.enter("restoring");
    step_ = running.step;
    parallel::check_peers(group_);
    // Breaks before this phase count at once, those of the phase, restored below, after their delay.
    break_release_.update_strengths(infinity);
    parallel::agree(group_, [&] {
      break_release_.restore(running.releases, phase_time());
      context_.law->restore(checkpoint.memory, body_.subdomain());
      motion_.restore(running.motion);
    });
    break_release_.update_strengths(phase_time());
    last_break_ = running.last_break;
    end_.restore(running.separation);
    if (load_watch_) {
      load_watch_->restore(running.load_check);
      restore_ended_loads(group_, body_.subdomain().layout, running.ended_loads, *options_.ending_loads);
    }
    result_.energy = checkpoint.energy;
    result_.frames = checkpoint.frames;
    result_.fragment_history = checkpoint.fragment_history;
    motion_.read(state_);
    output_.start_again();
  }

  void finish() {
    result_.time = phase_time();
    result_.last_break = time_of(last_break_);
    if (const auto unloaded = end_.separation().unloaded) result_.separated_at = time_of(*unloaded);
    if (result_.note.empty()) result_.end_time = time_of(std::min(step_, options_.grid.n_steps));
    result_.n_steps = step_;
    result_.n_forces = motion_.n_forces();
    result_.kinetic = result_.energy.back().kinetic;
    if (result_.arrested) {
      result_.external_work = motion_.external_work(load_time(), state_);
      result_.dissipated = motion_.dissipated_energy() + motion_.energy_lost_at_rest(state_);
    }
  }

  MotionContext context_;
  const parallel::Communicator& group_;
  fracture::BreakableBody& body_;
  MovingBody& motion_;
  const Splitting& splitting_;
  double load_time_;  // at the start of the phase [s]
  const PhaseOptions& options_;
  MotionState& state_;
  PhaseResult& result_;
  PhaseOutput output_;
  PhaseEnd end_;
  ReleasesSince releases_;
  std::unique_ptr<BreakingCheck> breaking_check_;
  BreakRelease break_release_;
  std::optional<LoadWatch> load_watch_;
  StepFailure failure_;
  std::int64_t step_ = 0;        // number of steps since the start of the phase
  std::int64_t last_break_ = 0;  // step; known to this rank, agreed at polls
  bool awaits_first_break_ = false;
  std::vector<std::int32_t> breaking_;               // at the end of this step
  std::optional<std::vector<std::int64_t>> pieces_;  // labels after this step, once needed
  bool ends_ = false;
};

}  // namespace

PhaseResult run_explicit_phase(const MotionContext& context, MovingBody& motion, const Splitting& splitting,
                               const EnergyAccount& account, double load_time, const PhaseOptions& options,
                               MotionState& state) {
  PhaseResult result;
  try {
    ExplicitPhase(context, motion, splitting, account, load_time, options, state, result).run();
  } catch (...) {
    if (options.on_failure) options.on_failure(std::move(result));
    throw;
  }
  return result;
}

}  // namespace crackle::dynamics
