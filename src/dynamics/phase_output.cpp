// SPDX-License-Identifier: GPL-3.0-or-later
#include "phase_output.h"

#include "dynamics/fragments.h"
#include "fracture/connectivity.h"
#include "parallel/agreement.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Share of the energy at the strength: far above rounding errors in a hardly loaded body.
constexpr double negligible_share = 1e-12;

/// Fragments are counted less often: finding them takes as long as some steps.
constexpr std::int64_t energy_rows_per_count = 4;

/// The steps after which a frame is stored.
std::vector<std::int64_t> frame_steps(int n_frames, std::int64_t n_steps) {
  std::vector<std::int64_t> steps;
  for (int k = 0; k < n_frames; ++k) {
    steps.push_back(n_frames == 1 ? n_steps : (n_steps * k + (n_frames - 1) / 2) / (n_frames - 1));
  }
  return steps;
}

/// The steps before and after each kink; none if they are denser than the energy rows, which then suffice.
std::vector<std::int64_t> kink_steps(const PhaseOptions& options) {
  std::vector<std::int64_t> steps;
  if (std::ssize(options.kinks) > options.n_energy_rows) return steps;
  for (const double time : options.kinks)
    for (const double step : {std::floor(time / options.grid.step), std::ceil(time / options.grid.step)})
      steps.push_back(std::llround(step));
  return steps;
}

}  // namespace

std::vector<double> kinetic_energies(const MotionContext& context, const MotionState& state) {
  const auto v = state.velocity.owned();
  const auto& mass = context.body->operators().node_mass;
  std::vector<double> energies(mass.size());
  for (std::size_t n = 0; n < mass.size(); ++n) {
    energies[n] =
        0.5 * mass[n] * (v[3 * n] * v[3 * n] + v[3 * n + 1] * v[3 * n + 1] + v[3 * n + 2] * v[3 * n + 2]);
  }
  return energies;
}

double kinetic_energy(const MotionContext& context, const MotionState& state) {
  return parallel::exact_sum(*context.group, kinetic_energies(context, state));
}

PhaseOutput::PhaseOutput(const MotionContext& context, const MovingBody& motion, const EnergyAccount& account,
                         double load_time, const PhaseOptions& options, MotionState& state,
                         PhaseResult& result)
    : context_(context),
      motion_(&motion),
      account_(&account),
      load_time_(load_time),
      options_(&options),
      state_(&state),
      result_(&result),
      row_interval_(std::max<std::int64_t>(1, options.grid.n_steps / options.n_energy_rows)),
      history_interval_(
          options.history_interval
              ? std::max<std::int64_t>(1, std::llround(*options.history_interval / options.grid.step))
              : row_interval_),
      frame_steps_(frame_steps(options.n_frames, options.grid.n_steps)),
      kink_steps_(kink_steps(options)),
      negligible_energy_(negligible_share *
                         energy_at_strength(*context.group, *context.body, context.law->strengths())) {}

bool PhaseOutput::is_frame(std::int64_t step) const {
  return std::ranges::binary_search(frame_steps_, step);
}

bool PhaseOutput::is_energy_row(std::int64_t step) const {
  return step % row_interval_ == 0 || step >= options_->grid.n_steps || is_frame(step);
}

bool PhaseOutput::is_count(std::int64_t step) const {
  return step % (energy_rows_per_count * row_interval_) == 0 || step >= options_->grid.n_steps ||
         is_frame(step);
}

bool PhaseOutput::is_history_row(std::int64_t step) const {
  return options_->on_history && (step % history_interval_ == 0 || step >= options_->grid.n_steps);
}

bool PhaseOutput::is_measured(std::int64_t step) const {
  return is_history_row(step) || (options_->on_history && (step % row_interval_ == 0 ||
                                                           std::ranges::binary_search(kink_steps_, step)));
}

bool PhaseOutput::is_due(std::int64_t step) const {
  return step <= options_->grid.n_steps && (is_energy_row(step) || is_measured(step));
}

EnergyRow PhaseOutput::measure(double time) const {
  const double work = motion_->external_work(load_time_ + time, *state_);
  return account_->row(time, {.kinetic = kinetic_energy(context_, *state_),
                              .strain = motion_->strain_energy(*state_),
                              .work = work,
                              .dissipated = motion_->dissipated_energy()});
}

Frame PhaseOutput::frame(double time) const {
  const auto gather = [&](const parallel::NodeField& field) {
    const auto values =
        parallel::gather_nodes(*context_.group, context_.body->subdomain().layout, field.owned());
    std::vector<float> result(values.size());
    std::ranges::transform(values, result.begin(), [](double value) { return static_cast<float>(value); });
    return result;
  };
  Frame frame{time, {}, {}, result_->energy.back().broken};
  frame.displacement = gather(state_->displacement);
  frame.velocity = gather(state_->velocity);
  return frame;
}

void PhaseOutput::write(std::int64_t step, bool is_last) {
  const parallel::Communicator& group = *context_.group;
  const double time = static_cast<double>(step) * options_->grid.step;
  group.enter("energy row");
  motion_->read(*state_);
  const EnergyRow row = measure(time);
  if (options_->on_history && (is_last || is_measured(step))) {
    group.enter("history");
    options_->on_history(row, *state_, is_last || is_history_row(step));
  }
  if (!is_last && !is_energy_row(step)) return;
  result_->energy.push_back(row);
  // The rows are equal on every rank.
  if (const auto fault = energy_fault(result_->energy, static_cast<std::size_t>(options_->n_energy_rows),
                                      negligible_energy_))
    throw std::runtime_error(*fault);
  if (options_->on_row) options_->on_row(row);
  if (is_frame(step)) {
    group.enter("frame");
    Frame taken = frame(time);
    if (group.is_root()) result_->frames.push_back(std::move(taken));
  }
  if (!is_last && !is_count(step)) return;
  group.enter("fragments");
  write_fragments(time);
  if (is_last || step >= options_->grid.n_steps) write_last_fragments();
}

void PhaseOutput::write_fragments(double time) {
  const parallel::Communicator& group = *context_.group;
  // Until something breaks, the pieces are those of the start.
  const bool is_known = has_labels_ && result_->energy.back().broken == 0;
  if (!is_known) labels_ = fracture::piece_labels(group, *context_.body);
  has_labels_ = true;
  remember_motion();
  if (!is_known) count_ = count_fragments(group, *context_.body, labels_, motion_->frozen(), time);
  count_.time = time;
  count_.frozen_energy = motion_->frozen_energy();
  parallel::agree_on_root(group, [&] { result_->fragment_history.push_back(count_); });
}

void PhaseOutput::remember_motion() {
  parallel::agree(*context_.group, [&] {
    const auto u = state_->displacement.owned(), v = state_->velocity.owned();
    displacement_.assign(u.begin(), u.end());
    velocity_.assign(v.begin(), v.end());
  });
}

void PhaseOutput::start_again() {
  labels_ = fracture::piece_labels(*context_.group, *context_.body);
  remember_motion();
}

void PhaseOutput::write_last_fragments() {
  result_->fragments =
      find_fragments(*context_.group, *context_.body, labels_, motion_->frozen(), displacement_, velocity_);
}

}  // namespace crackle::dynamics
