// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "dynamics/energy_account.h"
#include "dynamics/integrator.h"
#include "dynamics/moving_body.h"
#include "fracture/equivalent_stress.h"
#include "fracture/stress_screening.h"
#include "mechanics/fixed_point_force.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include "fixed_point_nodes.h"
#include "fixed_point_state.h"
#include "ghost_displacements.h"
#include "initial_force.h"
#include "state_range.h"
#include "terms.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfenv>
#include <cmath>

namespace crackle::dynamics {

namespace {

template <class Real>
class FixedPointMotion final : public MovingBody {
  using Integer = kernels::Integer<Real>;
  using Force = mechanics::FixedPointForce<Real>;
  using ForceQuanta = InitialForce<std::int64_t>::OfNode;
  static constexpr std::int32_t nodes_per_block = Force::nodes_per_block;
  static constexpr std::int64_t steps_between_unwrapping = 16;
  /// Number of forces computed in one pass over the body.
  static constexpr std::size_t forces_per_pass = 4;
  /// Blocks computed while new values of ghosts travel: some 30 us of work, which stays in the cache.
  static constexpr std::int32_t blocks_in_between = 32;
  /// An upper bound on the substeps of any splitting.
  static constexpr std::size_t max_substeps = 32;
  /// State and force may use the integers' range up to this limit; the rest is a safety margin for detecting
  /// overflow.
  static constexpr double limit = sizeof(Real) == 4 ? 0x1p30 : 0x1p50;
  /// From here on a loose piece is about to leave the range.
  static constexpr double near_limit = limit / 2;
  /// Below this strain the quantum of displacement resolves the stretch of an edge too coarsely: the energy
  /// is off by a few percent.
  static constexpr double least_strain = sizeof(Real) == 4 ? 1e-5 : 1e-8;

public:
  FixedPointMotion(const MotionContext& context, double load_time, double duration, MotionState& state,
                   InstructionSet instruction_set)
      : context_(context),
        subdomain_(context.body->subdomain()),
        terms_(context, state, nodes_per_block),
        reference_mass_(reference_mass(context)),
        range_(range_at_start(context, terms_, load_time, duration, state)),
        scale_(mechanics::fixed_point_scale<Real>(range_)),
        kernels_(kernels::kernels<Real>(instruction_set)),
        force_(subdomain_, context.body->operators(), context.body->elasticity(), context.body->edges(),
               context.body->residual_stiffness(), relative_inverse_mass(), scale_, instruction_set),
        screening_(subdomain_, context.body->operators(), context.body->elasticity(), context.law->stress(),
                   context.law->strengths(), context.law->screening_share(), initial_stresses(context),
                   scale_.displacement, energy_quantum(), nodes_per_block, instruction_set),
        state_(subdomain_, scale_, force_.nodes(), state),
        nodes_(context.body->operators().node_mass, scale_, state_),
        initial_force_(*context.body, [this](const auto& forces) { return force_quanta(forces); }),
        movement_(index(force_.n_blocks()) + n_ghost_blocks()),
        ghosts_(*context.group, subdomain_.layout, force_.nodes(),
                std::span(movement_).subspan(index(force_.n_blocks())), index(nodes_per_block)) {
    force_.let_ends_part();
    state_.read(state);
    terms_.start(load_time, state);
    for (const auto node : ghosts_.sent_nodes())
      sent_blocks_ = std::max(sent_blocks_, force_.block_of(node) + 1);
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t)
      if (subdomain_.owned[index(t)] != 0 && !screening_.has_energy(t)) single_energies_.push_back(t);
    for (const auto t : context.body->changes()) refresh_screening(t);
    n_contacts_ = context.body->residual_stiffness().contacts().size();
    cuts_.reserve(n_contacts_);
    substeps_.reserve(max_substeps);
    next_force_.reserve(max_substeps);
    next_update_.reserve(max_substeps);
    next_cut_.reserve(max_substeps);
  }

  void step(std::span<const Stage> stages, double time_step, double time) override {
    std::feclearexcept(FE_INVALID);
    state_.begin_step();
    state_.keep_displacements(index(subdomain_.layout.n_owned), subdomain_.nodes.size());
    substeps_of(stages, time_step, time, force_is_current_, substeps_);
    const std::span<const Substep> substeps = substeps_;
    if (force_is_current_ && !substeps.front().has_kick) clear_forces();
    find_cuts();
    // Nodes that others of any block act on need whole substeps.
    if (terms_.couple_nodes()) {
      for (const Substep& substep : substeps) run_substep(substep);
    } else {
      for (std::size_t first = 0, last = 0; first < substeps.size(); first = last) {
        for (std::size_t n = 0; last < substeps.size() && n + substeps[last].has_force <= forces_per_pass;
             ++last)
          n += substeps[last].has_force;
        run_wavefront(substeps.subspan(first, last - first));
      }
    }
    ghosts_.end();
    terms_.end_step({time, time + time_step}, nodes_);
    force_is_current_ = substeps.back().keeps_force;
    n_forces_ += std::ranges::count_if(substeps, &Substep::has_force);
    if (std::fetestexcept(FE_INVALID) != 0 || force_.has_overflown()) force_has_overflown_ = true;
    // Node positions can be recovered from their integers as long as nodes move less than half the integers'
    // range.
    const double change = max_displacement_change();
    ++n_steps_since_check_;
    if (change >= limit && n_steps_since_check_ <= steps_between_unwrapping) moves_too_far_ = true;
    if (++n_steps_ % steps_between_unwrapping == 0 || steps_between_unwrapping * change >= limit)
      state_.unwrap();
  }

  std::span<const std::int32_t> overloaded() override {
    overloaded_.clear();
    const auto& body = *context_.body;
    const auto strengths = context_.law->strengths();
    for (const auto t : screening_.candidates(force_.nodes(), movement_)) {
      if (body.is_broken(t)) continue;
      if (context_.law->stress().exceeds(body.intact_stress(t, strain(t)),
                                         context_.law->screening_share() * strengths[index(t)]))
        overloaded_.push_back(t);
    }
    stretch_bound_ += 2 * max_displacement_change();
    std::ranges::fill(movement_, kernels::Movement<double>{});
    n_steps_since_check_ = 0;
    return overloaded_;
  }

  /// From integer differences, which are exact, so that a translation of the whole body has no effect. The
  /// low digits do for an intact tetrahedron; the corners of a broken one may be anywhere.
  mechanics::Symmetric strain(std::int32_t number) const override {
    if (context_.body->is_broken(number))
      return strain_of(number, [&](std::int32_t node, std::size_t component) {
        return state_.whole_displacement(index(node), component);
      });
    return strain_of(number, [&](std::int32_t node, std::size_t component) {
      return force_.nodes()[index(node)].displacement[component];
    });
  }

  mechanics::Symmetric strain_before(std::int32_t number, int n_steps) const override {
    return strain_of(number, [&](std::int32_t node, std::size_t component) {
      return state_.displacement_before(index(node), n_steps)[component];
    });
  }

  void relative_displacements(std::span<const std::int32_t> nodes, int n_steps,
                              std::span<Vector> result) const override {
    const auto displacement = [&](std::int32_t node, std::size_t component) {
      return n_steps == 0 ? state_.whole_displacement(index(node), component)
                          : state_.whole_displacement_before(index(node), component, n_steps);
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t origin = displacement(nodes.front(), i);
      for (std::size_t n = 0; n < nodes.size(); ++n)
        result[n][i] = scale_.displacement * static_cast<double>(displacement(nodes[n], i) - origin);
    }
  }

  void release(std::span<const std::int32_t> broken) override {
    for (const auto t : broken) refresh_screening(t);
    force_.update(broken, force_is_current_);
    initial_force_.update(broken, [&](std::size_t node, const ForceQuanta& before) {
      if (!force_is_current_) return;
      for (std::size_t i = 0; i < 3; ++i)
        add_force(before[i] - initial_force_.values()[node][i], force_.nodes()[node].force[i]);
    });
    if (force_is_current_) add_contacts(n_contacts_);
    n_contacts_ = context_.body->residual_stiffness().contacts().size();
    cuts_.reserve(n_contacts_);
  }

  void update_strengths(std::span<const std::int32_t> tetrahedra) override {
    for (const auto t : tetrahedra) refresh_screening(t);
  }

  void read(MotionState& state) const override { state_.read(state); }

  double strain_energy(const MotionState& state) const override {
    const auto& body = *context_.body;
    if (!body.initial_strain().is_none())
      return dynamics::strain_energy(*context_.group, body, state.displacement.local()) +
             terms_.stored(state.displacement);
    const double of_others = parallel::exact_sum(*context_.group, single_energies());
    return energy_quantum() * parallel::integer_sum(*context_.group, screening_.energy(force_.nodes())) +
           of_others + terms_.stored(state.displacement);
  }

  double external_work(double time, const MotionState& state) const override {
    return terms_.supplied(time, state);
  }

  void end_loads(double time, const mechanics::NodesOfConditions& nodes, const MotionState& state) override {
    terms_.end_loads(time, nodes, state.displacement);
  }

  double dissipated_energy() const override { return terms_.dissipated() + frozen_energy_; }
  double energy_lost_at_rest(const MotionState& state) const override {
    return terms_.lost_at_rest(state.displacement);
  }
  LoadState measure(double time, const MotionState& state) const override {
    return terms_.measure(time, state.displacement, &state.velocity);
  }

  std::optional<std::string> failure() const override {
    const auto message = [&](const char* what, double quantum, const char* unit) {
      return fmt::format("the {} exceeds the range of +-{:.3g} {} of the {} number format for this input; {}",
                         what, limit * quantum, unit, sizeof(Real) == 4 ? "mixed" : "double",
                         sizeof(Real) == 4 ? "set time.precision = \"double\""
                                           : "the time integration is unstable, or strains are not small");
    };
    if (range_.strain < least_strain)
      return fmt::format("strains of {:.2g} are too small for the {} number format; set {}", range_.strain,
                         sizeof(Real) == 4 ? "mixed" : "double",
                         sizeof(Real) == 4
                             ? "time.precision = \"double\""
                             : "time.engine = \"petsc\", or raise the loads, which barely strain the body");
    if (force_has_overflown_ || !forces_are_in_range_ || !nodes_.forces_stay_in_range() ||
        largest_force_ >= limit)
      return message("force on a node", scale_.force, "N");
    // Edges are only checked once their ends may have separated that far.
    if (stretch_bound_ + 2 * max_displacement_change() >= limit) stretch_bound_ = force_.largest_stretch();
    if (stretch_bound_ >= limit) return message("stretch of an edge", scale_.displacement, "m");
    const auto velocity_message = [&] { return message("velocity of a node", scale_.velocity, "m/s"); };
    if (!state_.starts_in_range() || !nodes_.stay_in_range() || moves_too_far_) return velocity_message();
    for (const auto& velocity : state_.velocity())
      for (const Integer component : velocity.value)
        if (std::abs(static_cast<double>(component)) >= limit) return velocity_message();
    return {};
  }

  std::vector<std::int32_t> leaving() const override {
    std::vector<std::int32_t> nodes;
    force_.add_overstretched(near_limit, nodes);
    for (std::size_t n = 0; n < state_.velocity().size(); ++n)
      if (std::ranges::any_of(state_.velocity()[n].value, [](Integer component) {
            return std::abs(static_cast<double>(component)) >= near_limit;
          }))
        nodes.push_back(static_cast<std::int32_t>(n));
    if (!frozen_.empty())
      std::erase_if(nodes, [this](std::int32_t node) { return frozen_[index(node)] != 0; });
    return nodes;
  }

  void freeze(std::span<const std::int32_t> nodes, double energy) override {
    if (nodes.empty()) return;
    if (frozen_.empty()) frozen_.resize(subdomain_.nodes.size());
    has_frozen_.resize(index(force_.n_blocks()));
    for (const auto node : nodes) {
      frozen_[index(node)] = 1;
      if (node < subdomain_.layout.n_owned) has_frozen_[index(force_.block_of(node))] = 1;
    }
    for (std::int32_t b = 0; b < force_.n_blocks(); ++b) hold_frozen(b);
    frozen_energy_ += energy;
  }
  std::span<const std::uint8_t> frozen() const override { return frozen_; }
  double frozen_energy() const override { return frozen_energy_; }

  std::int64_t n_forces() const override { return n_forces_; }
  ExchangeCost exchange_cost() const override { return ghosts_.exchange_cost(); }

  MotionCheckpoint save() const override {
    MotionCheckpoint checkpoint;
    checkpoint.has_force = force_is_current_;
    checkpoint.nodes = parallel::gather_rows(*context_.group, state_.rows(force_is_current_));
    terms_.save(checkpoint);
    parallel::NumberedRows frozen;
    for (std::size_t n = 0; n < frozen_.size() && n < index(subdomain_.layout.n_owned); ++n)
      if (frozen_[n] != 0) frozen.add(subdomain_.layout.number[n], std::int64_t{1});
    checkpoint.frozen = parallel::gather_rows(*context_.group, frozen);
    checkpoint.frozen_energy = frozen_energy_;
    checkpoint.n_steps = n_steps_;
    checkpoint.n_forces = n_forces_;
    return checkpoint;
  }

  void restore(const MotionCheckpoint& checkpoint) override {
    clear_forces();
    state_.restore(checkpoint.nodes, checkpoint.has_force);
    force_is_current_ = checkpoint.has_force;
    terms_.restore(checkpoint);
    n_steps_ = checkpoint.n_steps;
    n_forces_ = checkpoint.n_forces;
    stretch_bound_ = limit;
    std::vector<std::int32_t> frozen;
    for (std::size_t n = 0; n < subdomain_.nodes.size(); ++n)
      if (!checkpoint.frozen.find(subdomain_.layout.number[n]).empty())
        frozen.push_back(static_cast<std::int32_t>(n));
    frozen_energy_ = checkpoint.frozen_energy;
    freeze(frozen, 0);
  }

private:
  double energy_quantum() const { return scale_.displacement * scale_.force; }

  /// Strain energies of the counted tetrahedra that the screening leaves out [J].
  std::vector<double> single_energies() const {
    const auto& residual_stiffness = context_.body->residual_stiffness();
    std::vector<double> energies;
    for (const auto t : single_energies_)
      if (residual_stiffness.carries(t) || residual_stiffness.has_contact(t))
        energies.push_back(residual_stiffness.energy(t, strain(t)));
    return energies;
  }

  /// Updates the screening of the breaking check.
  void refresh_screening(std::int32_t tetrahedron) {
    if (screening_.has_energy(tetrahedron) && !context_.body->residual_stiffness().is_intact(tetrahedron)) {
      screening_.leave_out_energy(tetrahedron);
      single_energies_.push_back(tetrahedron);
    }
    if (context_.body->is_broken(tetrahedron))
      screening_.exclude(tetrahedron);
    else
      screening_.set_strength(tetrahedron, context_.law->strength(index(tetrahedron)));
  }

  static double reference_mass(const MotionContext& context) {
    double largest = 0;
    for (const double mass : context.body->operators().node_mass) largest = std::max(largest, mass);
    parallel::check_peers(*context.group);
    return std::ldexp(1.0, std::ilogb(parallel::largest_of_all(*context.group, largest)));
  }

  static mechanics::StateRange range_at_start(const MotionContext& context, const Terms& terms,
                                              double load_time, double duration, MotionState& state) {
    terms.prescribe(load_time, state);
    parallel::check_peers(*context.group);
    state.displacement.update_ghosts();
    return expected_range(context, terms, load_time, duration, state);
  }

  /// The equivalent stress of each tetrahedron at zero displacement; empty if there is no initial strain.
  static std::vector<double> initial_stresses(const MotionContext& context) {
    const fracture::BreakableBody& body = *context.body;
    std::vector<double> stresses;
    for (std::int32_t t = 0; !body.initial_strain().is_none() && t < body.subdomain().n_tetrahedra(); ++t)
      stresses.push_back(context.law->stress()(
          body.intact_stress(t, body.initial_strain().elastic(t, mechanics::Symmetric{}))));
    return stresses;
  }

  /// The forces of a tetrahedron at its corners; corner 0 balances the others, so that the sum is exactly 0.
  std::array<ForceQuanta, 4> force_quanta(const std::array<Vector, 4>& forces) {
    std::array<ForceQuanta, 4> quanta{};
    for (std::size_t a = 1; a < 4; ++a)
      for (std::size_t i = 0; i < 3; ++i) {
        quanta[a][i] = quantized<Integer>(forces[a][i], scale_.force, forces_are_in_range_);
        quanta[0][i] -= quanta[a][i];
      }
    return quanta;
  }

  void add_force(std::int64_t change, Integer& force) {
    if (__builtin_add_overflow(force, change, &force)) forces_are_in_range_ = false;
  }

  std::size_t n_ghost_blocks() const {
    return (subdomain_.nodes.size() - index(subdomain_.layout.n_owned) + nodes_per_block - 1) /
           nodes_per_block;
  }

  std::vector<double> relative_inverse_mass() const {
    std::vector<double> inverse;
    for (const double mass : context_.body->operators().node_mass) inverse.push_back(reference_mass_ / mass);
    return inverse;
  }

  /// Bound on the change of any displacement component since the last breaking check, in quanta.
  double max_displacement_change() const {
    double largest = 0;
    for (const auto& movement : movement_)
      for (std::size_t c = 0; c < 3; ++c) largest = std::max({largest, movement.high[c], -movement.low[c]});
    return largest;
  }

  /// @param displacement of a local node in quanta
  template <class Displacement>
  mechanics::Symmetric strain_of(std::int32_t number, const Displacement& displacement) const {
    mechanics::TetrahedronOperator t = context_.body->operators().tetrahedra[index(number)];
    std::array<double, 12> u{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto origin = displacement(t.nodes[0], i);
      for (std::size_t a = 1; a < 4; ++a)
        u[3 * a + i] = scale_.displacement *
                       static_cast<double>(kernels::difference(displacement(t.nodes[a], i), origin));
    }
    t.nodes = {0, 1, 2, 3};
    return context_.body->initial_strain().elastic(number, mechanics::strain(t, u));
  }

  /// Displacements of corners relative to the first [m].
  std::array<Vector, 4> corner_displacements(const geometry::Tetrahedron& corners) const {
    std::array<Vector, 4> displacements{};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t origin = state_.whole_displacement(index(corners[0]), i);
      for (std::size_t a = 1; a < 4; ++a)
        displacements[a][i] = scale_.displacement *
                              static_cast<double>(state_.whole_displacement(index(corners[a]), i) - origin);
    }
    return displacements;
  }

  void clear_forces() {
    for (auto& node : force_.nodes()) std::ranges::fill(node.force, Integer(0));
  }

  /// Several substeps run through the body in one pass, each following the previous one as closely as the
  /// edges between blocks allow, so that the coefficients are loaded from memory only once. Ghost data are
  /// sent as soon as a substep has updated them, and awaited only when the next substep needs them.
  /// @param substeps only the first may lack a force
  void run_wavefront(std::span<const Substep> substeps) {
    const std::int32_t n = force_.n_blocks();
    auto& next_force = next_force_;
    auto& next_update = next_update_;
    next_force.assign(substeps.size(), 0);
    next_update.assign(substeps.size(), 0);
    next_cut_.assign(substeps.size(), 0);
    for (std::size_t r = 0; r < substeps.size(); ++r)
      if (!substeps[r].has_force) {
        next_force[r] = n;
        next_cut_[r] = cuts_.size();
      }
    // Nodes up to a block, and ghosts, are where the substep finds them.
    const auto is_ready = [&](std::size_t r, std::int32_t last_owned, bool has_ghosts) {
      if (r == 0) return true;
      if (last_owned >= next_update[r - 1]) return false;
      // A block with ghost neighbours has nodes that are ghosts elsewhere, so the previous substep no longer
      // needs the ghosts' former values. The blocks in between are computed while their new values travel.
      return !has_ghosts || next_update[r - 1] >= std::min(sent_blocks_ + blocks_in_between, n);
    };
    // Adds the forces of cuts to the next block, if it can.
    const auto add_cuts = [&](std::size_t r) {
      for (std::size_t& next = next_cut_[r]; next < cuts_.size() && cuts_[next].first_block <= next_update[r];
           ++next) {
        const Cut& cut = cuts_[next];
        if (!is_ready(r, cut.last_block, cut.has_ghosts)) return false;
        if (cut.has_ghosts) ghosts_.end();
        add_contact(cut.contact);
      }
      return true;
    };
    const auto update = [&](std::size_t r) {
      update_nodes(next_update[r]++, substeps[r]);
      if (substeps[r].has_drift && next_update[r] == sent_blocks_) ghosts_.begin();
    };
    while (next_update.back() < n) {
      for (std::size_t r = 0; r < substeps.size(); ++r) {
        const std::int32_t n_movable = r == 0 ? n : next_update[r - 1];
        if (!substeps[r].has_force) {
          if (next_update[r] < n_movable) update(r);
          continue;
        }
        if (next_force[r] < n) {
          const auto& reach = force_.reach(next_force[r]);
          if (is_ready(r, reach.last_owned, reach.has_ghosts)) {
            if (reach.has_ghosts) ghosts_.end();
            force_.add_block(next_force[r]++);
          }
        }
        while (next_update[r] < n_movable &&
               (next_force[r] == n || force_.last_contributor(next_update[r]) < next_force[r]) &&
               add_cuts(r)) {
          update(r);
        }
      }
    }
  }

  void run_substep(const Substep& substep) {
    if (substep.has_force) {
      for (std::int32_t b = 0; b < force_.n_blocks(); ++b) {
        if (force_.reach(b).has_ghosts) ghosts_.end();
        force_.add_block(b);
      }
      add_contacts(0);
      ghosts_.end();
      terms_.add_forces(nodes_);
    }
    for (std::int32_t b = 0; b < force_.n_blocks(); ++b) update_nodes(b, substep);
    if (substep.has_drift) ghosts_.begin();
  }

  /// Finds where the sweep meets the cuts whose contact may act.
  void find_cuts() {
    const auto& residual_stiffness = context_.body->residual_stiffness();
    if (std::exchange(cuts_version_, residual_stiffness.acting_version()) ==
        residual_stiffness.acting_version())
      return;
    cuts_.clear();
    for (const std::int32_t contact : residual_stiffness.acting()) {
      Cut cut{contact, force_.n_blocks(), -1, false};
      for (const std::int32_t node : residual_stiffness.cut_contact(index(contact)).corners) {
        if (node >= subdomain_.layout.n_owned) {
          cut.has_ghosts = true;
          continue;
        }
        cut.first_block = std::min(cut.first_block, force_.block_of(node));
        cut.last_block = std::max(cut.last_block, force_.block_of(node));
      }
      if (cut.last_block >= 0) cuts_.push_back(cut);
    }
    std::ranges::sort(cuts_, {}, &Cut::first_block);
  }

  /// Adds the contact forces of cuts `first` onwards.
  void add_contacts(std::size_t first) {
    const auto acting = context_.body->residual_stiffness().acting();
    for (auto contact = std::ranges::lower_bound(acting, static_cast<std::int32_t>(first));
         contact != acting.end(); ++contact)
      add_contact(*contact);
  }

  /// Adds the forces of a cut's contact; corner 0 balances the others, so that the sum is exactly 0.
  void add_contact(std::int32_t number) {
    const auto& residual_stiffness = context_.body->residual_stiffness();
    const auto nodes = force_.nodes();
    const auto c = index(number);
    const mechanics::CutContact& cut = residual_stiffness.cut_contact(c);
    const std::array<Vector, 4> displacement = corner_displacements(cut.corners);
    if (context_.body->initial_strain().is_none() && cut.opening(displacement) > mechanics::surely_open)
      return;
    const mechanics::Symmetric sigma = residual_stiffness.contact_stress(
        c,
        context_.body->initial_strain().elastic(residual_stiffness.contacts()[c], cut.strain(displacement)));
    if (sigma == mechanics::Symmetric{}) return;
    const mechanics::TetrahedronOperator& t = cut.intact;
    for (std::size_t a = 1; a < 4; ++a) {
      const auto traction = mechanics::apply(sigma, t.gradient[a]);
      for (std::size_t i = 0; i < 3; ++i) {
        const auto force = quantized<Integer>(t.volume * traction[i], scale_.force, forces_are_in_range_);
        auto& one = nodes[index(cut.corners[a])].force[i];
        auto& other = nodes[index(cut.corners[0])].force[i];
        // The sum of several contact forces may overflow even if each of them fits. Forces on ghosts are
        // never used, and never cleared.
        if (cut.corners[a] < subdomain_.layout.n_owned && __builtin_add_overflow(one, force, &one))
          forces_are_in_range_ = false;
        if (cut.corners[0] < subdomain_.layout.n_owned && __builtin_sub_overflow(other, force, &other))
          forces_are_in_range_ = false;
      }
    }
  }

  /// Takes velocity and force from the frozen nodes of a block.
  void hold_frozen(std::int32_t block) {
    if (has_frozen_.empty() || has_frozen_[index(block)] == 0) return;
    const auto first = index(force_.first_node(block));
    const std::size_t end = std::min(state_.velocity().size(), first + index(nodes_per_block));
    for (std::size_t n = first; n < end; ++n) {
      if (frozen_[n] == 0) continue;
      std::ranges::fill(state_.velocity()[n].value, Integer(0));
      std::ranges::fill(force_.nodes()[n].force, Integer(0));
    }
  }

  void update_nodes(std::int32_t block, const Substep& substep) {
    const auto first = index(force_.first_node(block));
    const auto number = first / nodes_per_block;
    const std::size_t n = std::min(state_.velocity().size() - first, index(nodes_per_block));
    kernels::NodeRecord<Real>* const nodes = state_.nodes().data() + first;
    kernels::Velocity<Real>* const velocity = state_.velocity().data() + first;
    if (substep.has_force && !initial_force_.is_none())
      for (std::size_t k = first; k < first + n; ++k)
        for (std::size_t i = 0; i < 3; ++i)
          add_force(-initial_force_.values()[k][i], force_.nodes()[k].force[i]);
    hold_frozen(block);
    kernels::NodeUpdate<Real> update{
        .has_kick = substep.has_kick,
        .has_drift = substep.has_drift,
        .keeps_force = substep.keeps_force,
        .kick = static_cast<Real>(-substep.kick * scale_.force / (scale_.velocity * reference_mass_)),
        .drift = static_cast<Real>(substep.drift * scale_.velocity / scale_.displacement),
        .kept = substep.is_first_drift ? state_.kept_displacements(first) : nullptr};
    kernels::NodeExtremes<Real> extremes{};
    if (terms_.act_on(number) && substep.has_kick) {
      // Terms act between kick and drift.
      terms_.before_kick(number, substep, nodes_);
      update.has_drift = false;
      track_force(kernels_.update(nodes, velocity, n, update).force);
      terms_.after_kick(number, substep, nodes_);
      hold_frozen(block);
      update.has_kick = false;
      update.has_drift = substep.has_drift;
    }
    if (update.has_kick || update.has_drift) extremes = kernels_.update(nodes, velocity, n, update);
    if (update.has_kick) track_force(extremes.force);
    if (substep.has_drift) {
      kernels::Movement<double> movement{};
      for (std::size_t c = 0; c < 3; ++c) {
        movement.low[c] = static_cast<double>(extremes.movement.low[c]) - 1;
        movement.high[c] = static_cast<double>(extremes.movement.high[c]) + 1;
      }
      terms_.after_drift(number, substep, nodes_);
      nodes_.extend(movement);
      for (std::size_t c = 0; c < 3; ++c) {
        movement_[number].low[c] += movement.low[c];
        movement_[number].high[c] += movement.high[c];
      }
    }
  }

  /// @param force largest magnitude on some nodes, in quanta
  void track_force(Real force) {
    if (!(static_cast<double>(force) <= largest_force_)) largest_force_ = static_cast<double>(force);
  }

  MotionContext context_;
  const geometry::Subdomain& subdomain_;
  Terms terms_;
  double reference_mass_;
  mechanics::StateRange range_;
  mechanics::FixedPointScale scale_;
  const kernels::Kernels<Real>& kernels_;
  Force force_;
  fracture::StressScreening<Real> screening_;
  FixedPointState<Real> state_;
  FixedPointNodes<Real> nodes_;
  bool forces_are_in_range_ = true;
  InitialForce<std::int64_t> initial_force_;
  std::vector<kernels::Movement<double>> movement_;  // per block of nodes, since the last breaking check
  GhostDisplacements<Real> ghosts_;
  std::vector<std::int32_t> overloaded_;
  std::vector<std::int32_t> single_energies_;  // counted tetrahedra without energy in the screening
  // The substeps of the current step; reserved for the longest step, since steps must not allocate.
  std::vector<Substep> substeps_;
  std::vector<std::int32_t> next_force_, next_update_;
  std::vector<std::size_t> next_cut_;
  bool force_is_current_ = false;
  std::size_t n_contacts_ = 0;  // included in the nodal forces
  /// A cut whose contact may act.
  struct Cut {
    std::int32_t contact;
    std::int32_t first_block, last_block;  // of its owned nodes
    bool has_ghosts;
  };
  std::vector<Cut> cuts_;           // by their first blocks; with room for all contacts
  std::int64_t cuts_version_ = -1;  // of the acting contacts
  std::int32_t sent_blocks_ = 1;    // one past the last block with nodes that are ghosts elsewhere
  std::vector<std::uint8_t> frozen_, has_frozen_;  // of local nodes and of blocks; empty if none is
  double frozen_energy_ = 0;                       // of all ranks [J]
  bool force_has_overflown_ = false;
  bool moves_too_far_ = false;
  std::int64_t n_steps_since_check_ = 0;
  double largest_force_ = 0;
  mutable double stretch_bound_ =
      limit;  // over all edges that carry load, at the last breaking check, in quanta
  std::int64_t n_steps_ = 0;
  std::int64_t n_forces_ = 0;
};

}  // namespace

std::unique_ptr<MovingBody> make_fixed_point_motion(const MotionContext& context, input::Precision precision,
                                                    double load_time, double duration, MotionState& state,
                                                    InstructionSet instruction_set) {
  if (precision == input::Precision::mixed)
    return std::make_unique<FixedPointMotion<float>>(context, load_time, duration, state, instruction_set);
  return std::make_unique<FixedPointMotion<double>>(context, load_time, duration, state, instruction_set);
}

}  // namespace crackle::dynamics
