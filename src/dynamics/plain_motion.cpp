// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "dynamics/energy_account.h"
#include "dynamics/moving_body.h"
#include "fracture/equivalent_stress.h"
#include "mechanics/petsc_stiffness.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "initial_force.h"
#include "terms.h"

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

/// The nodes of a state, for its terms.
class PlainNodes final : public MovingNodes {
public:
  /// The references must outlive the object.
  /// @param inverse_mass of each component
  /// @param before displacement of local nodes at the start of the last step
  PlainNodes(MotionState& state, parallel::NodeField& force, const std::vector<double>& inverse_mass,
             const std::vector<double>& before)
      : state_(&state), force_(&force), inverse_mass_(&inverse_mass), before_(&before) {}

  double displacement(std::int32_t node, int component) const override {
    return std::as_const(state_->displacement).local()[index(node, component)];
  }
  double velocity(std::int32_t node, int component) const override {
    return std::as_const(state_->velocity).owned()[index(node, component)];
  }
  double internal_force(std::int32_t node, int component) const override {
    return std::as_const(*force_).owned()[index(node, component)];
  }
  void kick(std::int32_t node, int component, double duration, double force, double&) override {
    const auto i = index(node, component);
    state_->velocity.owned()[i] += duration * (*inverse_mass_)[i] * force;
  }
  double change_velocity(std::int32_t node, int component, double change, double duration) override {
    state_->velocity.owned()[index(node, component)] += change;
    state_->displacement.owned()[index(node, component)] += duration * change;
    return change;
  }
  void set_velocity(std::int32_t node, int component, double velocity) override {
    state_->velocity.owned()[index(node, component)] = velocity;
  }
  void drive(std::int32_t node, int component, double displacement, double velocity, double) override {
    state_->displacement.owned()[index(node, component)] = displacement;
    set_velocity(node, component, velocity);
  }
  void add_balanced_forces(std::span<const std::int32_t> nodes, std::span<const Vector> forces) override {
    const auto f = force_->owned();
    for (std::size_t k = 1; k < nodes.size(); ++k)
      for (std::size_t i = 0; i < 3; ++i) {
        if (nodes[k] >= 0) f[index(nodes[k], i)] -= forces[k][i];
        if (nodes[0] >= 0) f[index(nodes[0], i)] += forces[k][i];
      }
  }
  void movements(std::span<Vector> moved) const override {
    const auto u = std::as_const(state_->displacement).local();
    for (std::size_t n = 0; n < moved.size(); ++n)
      for (std::size_t i = 0; i < 3; ++i) moved[n][i] = u[3 * n + i] - (*before_)[3 * n + i];
  }
  double force_quantum() const override { return 0; }

private:
  MotionState* state_;
  parallel::NodeField* force_;
  const std::vector<double>* inverse_mass_;
  const std::vector<double>* before_;
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
        terms_(context, state, std::max(1, context.body->subdomain().layout.n_owned)),
        nodes_(state, force_, inverse_mass_, before_[0]) {
    terms_.prescribe(load_time, state);
    parallel::check_peers(*context.group);
    state.displacement.update_ghosts();
    terms_.start(load_time, state);
    for (std::size_t i = 0; i < inverse_mass_.size(); ++i)
      inverse_mass_[i] = 1 / context.body->operators().node_mass[i / 3];
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
        kick({.kick = stage.fraction * time_step,
              .kick_time = time + elapsed * time_step,
              .step = {time, time + time_step}});
      } else {
        elapsed += stage.fraction;
        drift({.drift = stage.fraction * time_step,
               .drift_time = time + elapsed * time_step,
               .step = {time, time + time_step}});
      }
    }
    state_->displacement.update_ghosts();
    terms_.end_step({time, time + time_step}, nodes_);
  }

  std::span<const std::int32_t> overloaded() override {
    overloaded_.clear();
    const auto& body = *context_.body;
    for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
      if (body.is_broken(t)) continue;
      const auto& law = *context_.law;
      if (law.stress().exceeds(body.intact_stress(t, strain(t)),
                               context_.law->screening_share() * law.strength(index(t))))
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
    return dynamics::strain_energy(*context_.group, *context_.body, state.displacement.local()) +
           terms_.stored(state.displacement);
  }

  double external_work(double time, const MotionState& state) const override {
    return terms_.supplied(time, state);
  }
  void end_loads(double time, const mechanics::NodesOfConditions& nodes, const MotionState& state) override {
    terms_.end_loads(time, nodes, state.displacement);
  }

  double dissipated_energy() const override { return terms_.dissipated(); }
  double energy_lost_at_rest(const MotionState& state) const override {
    return terms_.lost_at_rest(state.displacement);
  }
  LoadState measure(double time, const MotionState& state) const override {
    return terms_.measure(time, state.displacement, &state.velocity);
  }
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
    terms_.save(checkpoint);
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
    terms_.restore(checkpoint);
    force_is_current_ = false;
    n_forces_ = checkpoint.n_forces;
  }

private:
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

  void kick(const Substep& substep) {
    if (!force_is_current_) {
      product_.apply(state_->displacement, force_);
      terms_.add_forces(nodes_);
      force_is_current_ = true;
      ++n_forces_;
    }
    const auto f = std::as_const(force_).owned();
    const auto v = state_->velocity.owned();
    terms_.before_kick(0, substep, nodes_);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= substep.kick * inverse_mass_[i] * f[i];
    terms_.after_kick(0, substep, nodes_);
  }

  void drift(const Substep& substep) {
    const auto u = state_->displacement.owned();
    const auto v = state_->velocity.owned();
    for (std::size_t i = 0; i < u.size(); ++i) u[i] += substep.drift * v[i];
    terms_.after_drift(0, substep, nodes_);
    force_is_current_ = false;
  }

  MotionContext context_;
  MotionState* state_;
  // Displacements of local nodes at the starts of the last two steps.
  std::array<std::vector<double>, 2> before_;
  Product product_;
  parallel::NodeField force_;
  std::vector<double> inverse_mass_;  // of each component
  Terms terms_;
  PlainNodes nodes_;
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
