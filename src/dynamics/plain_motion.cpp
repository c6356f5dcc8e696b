// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/index.h"
#include "crackle/dynamics/energy_account.h"
#include "crackle/dynamics/moving_body.h"
#include "crackle/fracture/equivalent_stress.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include "dampers.h"
#include "external_work.h"
#include "initial_force.h"
#include "viscous_force.h"

#include "mechanics/petsc_stiffness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace crackle::dynamics {

namespace {

/// Product by the plain loop over tetrahedra.
class ReferenceProduct {
public:
  explicit ReferenceProduct(const MotionContext& context) : force_(&context.body->force()) {}

  void apply(parallel::NodeField& displacement, parallel::NodeField& force) const {
    displacement.update_ghosts();
    force_->evaluate(displacement.local(), force.local());
  }
  void update(std::span<const std::int32_t>) {}
  void assemble() {}

private:
  const mechanics::InternalForce* force_;
};

/// Product by PETSc's matrix.
class PetscProduct {
public:
  explicit PetscProduct(const MotionContext& context)
      : stiffness_(*context.group, context.body->subdomain(), context.body->operators(),
                   context.body->elasticity(), context.body->residual_stiffness()),
        initial_force_(*context.body, [](const std::array<Vector, 4>& forces) { return forces; }) {}

  void apply(parallel::NodeField& displacement, parallel::NodeField& force) const {
    stiffness_.apply(displacement, force);
    const auto initial = initial_force_.values();
    const auto f = force.owned();
    for (std::size_t n = 0; n < initial.size(); ++n)
      for (std::size_t i = 0; i < 3; ++i) f[3 * n + i] -= initial[n][i];
  }
  void update(std::span<const std::int32_t> tetrahedra) {
    stiffness_.update(tetrahedra);
    initial_force_.update(tetrahedra, [](std::size_t, const Vector&) {});
  }
  void assemble() { stiffness_.assemble(); }

private:
  mechanics::PetscStiffness stiffness_;
  InitialForce<double> initial_force_;
};

/// All operations in sequence, in double precision, on the caller's state.
/// @tparam Product the internal force of a displacement: apply() and assemble() are collective, update() is
/// local
template <class Product>
class PlainMotion final : public MovingBody {
public:
  PlainMotion(const MotionContext& context, double load_time, MotionState& state)
      : context_(context),
        state_(&state),
        product_(context),
        force_(*context.group, context.body->subdomain().layout),
        inverse_mass_(state.displacement.owned().size()),
        work_(start_work(context, load_time, state)),
        dampers_(context),
        viscosity_(context.body->subdomain(), context.body->operators(), context.body->material(),
                   context.bulk_viscosity),
        viscous_force_(dampers_.are_viscous() ? inverse_mass_.size() / 3 : 0) {
    for (std::size_t i = 0; i < inverse_mass_.size(); ++i)
      inverse_mass_[i] = 1 / context.body->operators().node_mass[i / 3];
    for (const auto& motion : context.loads->motions)
      for (const auto node : motion.nodes) inverse_mass_[index(node, motion.component)] = 0;
    for (auto& before : before_)
      before.assign(state.displacement.local().begin(), state.displacement.local().end());
  }

  void step(std::span<const Stage> stages, double time_step, double time) override {
    // No allocations here: a rank that threw would leave the others waiting.
    std::swap(before_[0], before_[1]);
    std::ranges::copy(state_->displacement.local(), before_[0].begin());
    take_over_releases();
    double elapsed = 0;  // in steps, by the drifts done
    for (const Stage& stage : stages) {
      if (stage.kind == Stage::Kind::kick) {
        kick(stage.fraction * time_step, time + elapsed * time_step, {time, time + time_step});
      } else {
        elapsed += stage.fraction;
        drift(stage.fraction * time_step, time + elapsed * time_step);
      }
    }
    state_->displacement.update_ghosts();
    if (dampers_.are_viscous()) resist({time, time + time_step});
  }

  std::span<const std::int32_t> overloaded() override {
    overloaded_.clear();
    const auto& body = *context_.body;
    for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
      if (body.is_broken(t)) continue;
      const auto& criterion = *context_.criterion;
      if (criterion.stress().exceeds(body.intact_stress(t, strain(t)),
                                     context_.screening_share * criterion.strength(index(t))))
        overloaded_.push_back(t);
    }
    return overloaded_;
  }

  mechanics::Symmetric strain(std::int32_t tetrahedron) const override {
    return context_.body->strain(tetrahedron, state_->displacement.local());
  }

  mechanics::Symmetric strain_before(std::int32_t tetrahedron, int n_steps) const override {
    return context_.body->strain(tetrahedron, before_[n_steps == 1 ? 0 : 1]);
  }

  void relative_displacements(std::span<const std::int32_t> nodes, int n_steps,
                              std::span<Vector> result) const override {
    const std::span<const double> u =
        n_steps == 0 ? std::span<const double>(state_->displacement.local()) : before_[n_steps == 1 ? 0 : 1];
    for (std::size_t n = 0; n < nodes.size(); ++n)
      for (int i = 0; i < 3; ++i) result[n][index(i)] = u[index(nodes[n], i)] - u[index(nodes.front(), i)];
  }

  void release(std::span<const std::int32_t> broken) override {
    if (broken.empty()) return;
    has_released_ = true;
    product_.update(broken);
  }

  void read(MotionState& state) const override {
    if (&state == state_) return;
    state.displacement.assign(state_->displacement);
    state.velocity.assign(state_->velocity);
  }

  double strain_energy(const MotionState& state) const override {
    return dynamics::strain_energy(*context_.group, *context_.body, state.displacement.local());
  }

  double external_work(double time, const MotionState& state) const override {
    return work_.value(time, state);
  }
  void end_loads(double time, const mechanics::NodesOfConditions& nodes, const MotionState& state) override {
    work_.end_loads(time, nodes, state);
  }

  double dissipated_energy() const override { return dampers_.dissipated_energy(); }
  std::int64_t n_forces() const override { return n_forces_; }

  std::optional<std::string> failure() const override {
    const auto is_finite = [](double value) { return std::isfinite(value); };
    for (const auto& [name, field] :
         {std::pair{"displacement", &state_->displacement}, std::pair{"velocity", &state_->velocity}}) {
      const auto values = std::as_const(*field).owned();
      const auto place = std::ranges::find_if_not(values, is_finite) - values.begin();
      if (place == std::ssize(values)) continue;
      const auto node = context_.body->subdomain().layout.number[index(place) / 3];
      return fmt::format("the {} of node {} is not finite", name, node);
    }
    return {};
  }

  MotionCheckpoint save() const override {
    parallel::check_peers(*context_.group);
    const bool force_is_kept = force_is_current_ && !is_released_anywhere();
    MotionCheckpoint checkpoint;
    parallel::NumberedRows local;
    local.width = 9;
    const auto u = state_->displacement.owned(), v = state_->velocity.owned();
    const auto before = std::span<const double>(before_[0]).first(u.size());
    for (std::size_t n = 0; 3 * n < u.size(); ++n) {
      local.numbers.push_back(context_.body->subdomain().layout.number[n]);
      for (const std::span<const double> values :
           {std::span<const double>(u), std::span<const double>(v), before})
        for (std::size_t c = 0; c < 3; ++c)
          local.values.push_back(std::bit_cast<std::int64_t>(values[3 * n + c]));
    }
    checkpoint.nodes = parallel::gather_rows(*context_.group, local);
    work_.save(checkpoint);
    dampers_.save(checkpoint);
    // The force is evaluated again after a restart, which counts it again.
    checkpoint.n_forces = n_forces_ - (force_is_kept ? 1 : 0);
    return checkpoint;
  }

  void restore(const MotionCheckpoint& checkpoint) override {
    const auto u = state_->displacement.local();
    const auto v = state_->velocity.owned();
    for (std::size_t i = 0; i < u.size(); ++i) {
      const auto row = checkpoint.nodes.find(context_.body->subdomain().layout.number[i / 3]);
      if (row.empty()) throw std::runtime_error("the checkpoint belongs to another mesh");
      u[i] = std::bit_cast<double>(row[i % 3]);
      before_[0][i] = std::bit_cast<double>(row[6 + i % 3]);
      if (i < v.size()) v[i] = std::bit_cast<double>(row[3 + i % 3]);
    }
    work_.restore(checkpoint);
    dampers_.restore(checkpoint);
    force_is_current_ = false;
    n_forces_ = checkpoint.n_forces;
  }

private:
  /// Access for the dampers.
  struct DampedNodes {
    std::span<double> displacements, velocities;
    double half_drift;

    double velocity(std::int32_t node, std::size_t c) const { return velocities[index(node, c)]; }
    double change(std::int32_t node, std::size_t c, double change) {
      velocities[index(node, c)] += change;
      displacements[index(node, c)] += half_drift * change;
      return change;
    }
  };

  static ExternalWork start_work(const MotionContext& context, double load_time, MotionState& state) {
    const auto driven = driven_kinetic(context, state);
    set_prescribed(*context.loads, load_time, state);
    parallel::check_peers(*context.group);
    state.displacement.update_ghosts();
    return ExternalWork(context, load_time, state, driven);
  }

  /// True if any rank has released tetrahedra since the last step. Collective.
  bool is_released_anywhere() const { return parallel::any_of_all(*context_.group, has_released_); }

  /// On all ranks together, as assembly of the product is collective.
  void take_over_releases() {
    const bool is_due = is_released_anywhere();
    has_released_ = false;
    if (!is_due) return;
    product_.assemble();
    force_is_current_ = false;
  }

  void kick(double duration, double time, const mechanics::StepSpan& step) {
    if (!force_is_current_) {
      product_.apply(state_->displacement, force_);
      force_is_current_ = true;
      ++n_forces_;
    }
    const auto f = std::as_const(force_).owned();
    const auto v = state_->velocity.owned();
    // Loads act on few nodes and are added after the sweep over the internal force.
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= duration * inverse_mass_[i] * f[i];
    const auto& loads = *context_.loads;
    for (std::size_t k = 0; k < loads.forces.size(); ++k) {
      const auto& pattern = loads.forces[k];
      const double amplitude = pattern.amplitude.at(time);
      const double slope = pattern.amplitude.slope(time, step);
      for (std::size_t n = 0; n < pattern.nodes.size(); ++n) {
        const auto i = index(pattern.nodes[n], pattern.component);
        v[i] += duration * inverse_mass_[i] * (amplitude * pattern.weight[n]);
        work_.add_rate(k, n, duration * slope, state_->displacement.owned()[i]);
      }
    }
    for (std::size_t m = 0; m < loads.motions.size(); ++m) {
      const auto& motion = loads.motions[m];
      const double velocity = motion.velocity(time, step);
      if (velocity == 0) continue;
      for (std::size_t n = 0; n < motion.nodes.size(); ++n)
        work_.add_reaction(m, n, duration * motion.factor_at(n) * velocity,
                           f[index(motion.nodes[n], motion.component)]);
    }
  }

  void drift(double duration, double time_after) {
    const auto u = state_->displacement.owned();
    const auto v = state_->velocity.owned();
    for (std::size_t i = 0; i < u.size(); ++i) u[i] += duration * v[i];
    DampedNodes nodes{u, v, 0.5 * duration};
    dampers_.slow_down(0, static_cast<std::int32_t>(u.size() / 3), duration, nodes, 1);
    set_prescribed(*context_.loads, time_after, *state_);
    force_is_current_ = false;
  }

  void resist(const mechanics::StepSpan& step) {
    std::ranges::fill(viscous_force_, Vector{});
    const std::span<const double> u = state_->displacement.local(), before = before_[0];
    viscosity_.find(
        context_.body->residual_stiffness(), step.end - step.begin,
        [&](std::int32_t a, std::int32_t b, std::size_t i) {
          return (u[index(a, i)] - u[index(b, i)]) - (before[index(a, i)] - before[index(b, i)]);
        },
        [](double value) { return value; },
        [&](std::int32_t node, std::size_t i, double value) {
          if (index(node) < viscous_force_.size()) viscous_force_[index(node)][i] += value;
        });
    DampedNodes nodes{state_->displacement.owned(), state_->velocity.owned(), 0};
    dampers_.resist(step, std::span(viscous_force_), 1, nodes, 1, work_);
  }

  MotionContext context_;
  MotionState* state_;
  // Displacements of local nodes at the starts of the last two steps.
  std::array<std::vector<double>, 2> before_;
  Product product_;
  parallel::NodeField force_;
  std::vector<double> inverse_mass_;  // 0 for prescribed components
  ExternalWork work_;
  Dampers dampers_;
  ViscousForce viscosity_;
  std::vector<Vector> viscous_force_;  // of owned nodes
  std::vector<std::int32_t> overloaded_;
  bool force_is_current_ = false;  // equal on all ranks
  bool has_released_ = false;      // since the last step, on this rank
  std::int64_t n_forces_ = 0;
};

}  // namespace

std::unique_ptr<MovingBody> make_reference_motion(const MotionContext& context, double load_time,
                                                  MotionState& state) {
  return std::make_unique<PlainMotion<ReferenceProduct>>(context, load_time, state);
}

std::unique_ptr<MovingBody> make_petsc_motion(const MotionContext& context, double load_time,
                                              MotionState& state) {
  return std::make_unique<PlainMotion<PetscProduct>>(context, load_time, state);
}

std::unique_ptr<MovingBody> make_motion(const MotionContext& context, const input::Time& parameters,
                                        double load_time, double duration, MotionState& state) {
  if (parameters.engine == input::Engine::petsc) return make_petsc_motion(context, load_time, state);
  return make_fixed_point_motion(context, parameters.precision, load_time, duration, state);
}

}  // namespace crackle::dynamics
