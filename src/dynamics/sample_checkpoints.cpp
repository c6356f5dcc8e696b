// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample_checkpoints.h"

#include "common/index.h"
#include "dynamics/contact_at_rest.h"

#include "loose_loads.h"

#include <fmt/format.h>

#include <bit>
#include <exception>
#include <utility>

namespace crackle::dynamics {

namespace {

constexpr const char* mismatch_text =
    "the repeated quasi-static loading gives other dynamic phases than before";

parallel::NumberedRows gather_displacement(const parallel::Communicator& group,
                                           const parallel::NodeLayout& layout, const MotionState& state) {
  parallel::NumberedRows local;
  local.width = 3;
  const auto u = state.displacement.owned();
  for (std::size_t n = 0; 3 * n < u.size(); ++n) {
    local.numbers.push_back(layout.number[n]);
    for (std::size_t c = 0; c < 3; ++c) local.values.push_back(std::bit_cast<std::int64_t>(u[3 * n + c]));
  }
  return parallel::gather_rows(group, local);
}

}  // namespace

SampleCheckpoints::SampleCheckpoints(SampleSetup& setup, const SampleControl& control, const Checkpoint* from)
    : first_break_reaction(from == nullptr ? 0 : from->first_break_reaction),
      setup_(&setup),
      control_(&control),
      from_(from) {}

Request SampleCheckpoints::request() const {
  if (control_->stop && control_->stop()) return Request::suspend;
  const bool is_due =
      setup_->group.is_root() && since_save_.seconds() >= control_->checkpoint_interval && control_->save;
  return is_due ? Request::save : Request::go_on;
}

const EndedPhase* SampleCheckpoints::ended(std::int64_t phase, double load_time) const {
  if (from_ == nullptr || phase > std::ssize(from_->ended)) return nullptr;
  const EndedPhase& ended = from_->ended[index(phase - 1)];
  if (ended.load_time != load_time ||
      std::ssize(ended.displacement.numbers) != setup_->subdomain.layout.n_global)
    throw CheckpointMismatch(mismatch_text);
  return &ended;
}

const Checkpoint* SampleCheckpoints::running(std::int64_t phase, double load_time) const {
  if (from_ == nullptr || phase != std::ssize(from_->ended) + 1 || !from_->running) return nullptr;
  if (from_->running->load_time != load_time) throw CheckpointMismatch(mismatch_text);
  return from_;
}

const Checkpoint& SampleCheckpoints::restore(const EndedPhase& phase, MotionState& state) {
  const parallel::NodeLayout& layout = setup_->subdomain.layout;
  setup_->law.restore(phase.releases, setup_->body);
  const auto u = state.displacement.local();
  for (std::size_t i = 0; i < u.size(); ++i) {
    const auto row = phase.displacement.find(layout.number[i / 3]);
    u[i] = std::bit_cast<double>(row[i % 3]);
  }
  restore_ended_loads(setup_->group, layout, phase.ended_loads, setup_->loads);
  setup_->law.restore(from_->memory, setup_->subdomain);
  restore_cuts(phase.cuts, setup_->body);
  add(phase);
  return *from_;
}

EndedPhase SampleCheckpoints::gather(const PhaseResult& phase, double load_time,
                                     const ReleasesSince& releases, const MotionState& state,
                                     std::vector<HistoryRow> history) const {
  const parallel::Communicator& group = setup_->group;
  const parallel::NodeLayout& layout = setup_->subdomain.layout;
  return {.load_time = load_time,
          .time = phase.time,
          .kinetic = phase.kinetic,
          .external_work = phase.external_work,
          .dissipated = phase.dissipated,
          .separated_at = phase.separated_at,
          .last_break = phase.last_break,
          .n_steps = phase.n_steps,
          .n_forces = phase.n_forces,
          .releases = releases.gather(group),
          .displacement = gather_displacement(group, layout, state),
          .history = std::move(history),
          .ended_loads = gather_ended_loads(group, layout, setup_->loads),
          .cuts = save_cuts(group, setup_->body)};
}

void SampleCheckpoints::save(std::optional<RunningPhase> running, const std::vector<EnergyRow>& energy,
                             const std::vector<Frame>& frames,
                             const std::vector<FragmentCount>& fragment_history) {
  const Checkpoint checkpoint{.precision = setup_->model.time.precision,
                              .engine = setup_->model.time.engine,
                              .first_break_reaction = first_break_reaction,
                              .ended = ended_,
                              .running = std::move(running),
                              .memory = setup_->law.save(setup_->group, setup_->subdomain),
                              .energy = energy,
                              .frames = frames,
                              .fragment_history = fragment_history};
  since_save_ = Stopwatch();
  if (!control_->save || !setup_->group.is_root()) return;
  try {
    control_->save(to_bytes(checkpoint));
  } catch (const std::exception& error) {
    if (control_->log) control_->log(fmt::format("the checkpoint could not be written: {}", error.what()));
  }
}

}  // namespace crackle::dynamics
