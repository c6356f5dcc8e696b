// SPDX-License-Identifier: GPL-3.0-or-later
#include "phase_end.h"

#include "dynamics/separation.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

namespace crackle::dynamics {

namespace {

/// Maximum number of checks for separation in a phase.
constexpr std::int64_t checks_for_separation = 100;

}  // namespace

PhaseEnd::PhaseEnd(const MotionContext& context, const PhaseOptions& options)
    : context_(context),
      options_(&options),
      last_step_(options.arrest_window ? max_phase_durations * options.grid.n_steps : options.grid.n_steps),
      watch_(*context.group, *context.body, *context.loads) {}

bool PhaseEnd::is_arrested(std::int64_t step, std::int64_t last_break) const {
  if (!options_->arrest_window) return false;
  if (options_->awaits_break && last_break == 0) return step >= options_->grid.n_steps;
  const bool has_none = last_break == 0 && step >= last_step_;
  return has_none || static_cast<double>(step - last_break) * options_->grid.step >= *options_->arrest_window;
}

bool PhaseEnd::must_check_separation(std::int64_t step, std::int64_t last_break) const {
  const std::int64_t n_steps = options_->grid.n_steps;
  const std::int64_t pause = step >= n_steps ? 0 : n_steps / checks_for_separation;
  const bool is_known = separation_.found && separation_.unloaded;
  return !is_arrested(step, last_break) && !is_known && last_break > separation_.checked_at &&
         step >= separation_.checked_at + pause;
}

void PhaseEnd::check_separation(std::int64_t step, std::int64_t last_break,
                                const std::function<const std::vector<std::int64_t>&()>& labels) {
  const parallel::Communicator& group = *context_.group;
  separation_.checked_at = step;
  const bool may_have_parted = parallel::agree(group, [&] { return watch_.may_have_parted(); });
  if (!separation_.found && !parallel::any_of_all(group, may_have_parted)) return;
  if (!separation_.found && is_separated(group, *context_.body, *context_.loads, labels()))
    separation_.found = step;
  // Conditions separated by edges are also separated by faces.
  if (!separation_.unloaded && is_unloaded(group, *context_.body, *context_.loads, labels()))
    separation_.unloaded = last_break;
}

bool PhaseEnd::is_reached(std::int64_t step, std::int64_t last_break) const {
  if (is_arrested(step, last_break) || step >= last_step_) return true;
  // Without separation a phase in which breaking continues goes on beyond its duration.
  if (step >= options_->grid.n_steps && (separation_.found || !options_->arrest_window)) return true;
  return separation_.found && options_->after_separation &&
         static_cast<double>(step - *separation_.found) * options_->grid.step >= *options_->after_separation;
}

}  // namespace crackle::dynamics
