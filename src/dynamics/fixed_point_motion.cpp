// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/moving_body.h"

#include "crackle/fracture/principal_stress.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/ghost_exchange.h"
#include "crackle/stopwatch.h"
#include "external_work.h"
#include "state_range.h"

#include "fracture/stress_watch.h"
#include "mechanics/fixed_point_force.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <stdexcept>

namespace crackle::dynamics {

namespace {

constexpr std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// One force evaluation with the kick and the drift that follow it; any part may be missing.
struct Round {
  bool has_force = false;
  bool has_kick = false;
  bool has_drift = false;
  bool keeps_force = false;  // for the next step, which begins with a kick from the same displacement
  double kick = 0;           // duration [s]
  double kick_time = 0;
  double drift = 0;       // duration [s]
  double drift_time = 0;  // at its end
};

std::vector<Round> rounds_of(std::span<const Stage> stages, double time_step, double time,
                             bool force_is_current) {
  std::vector<Round> rounds;
  double elapsed = 0;  // in steps, by the drifts done
  for (const Stage& stage : stages) {
    if (stage.kind == Stage::Kind::kick) {
      Round& round = rounds.emplace_back();
      round.has_force = round.has_kick = true;
      round.kick = stage.fraction * time_step;
      round.kick_time = time + elapsed * time_step;
    } else {
      if (rounds.empty() || rounds.back().has_drift) rounds.emplace_back();
      Round& round = rounds.back();
      elapsed += stage.fraction;
      round.has_drift = true;
      round.drift = stage.fraction * time_step;
      round.drift_time = time + elapsed * time_step;
    }
  }
  if (force_is_current && rounds.front().has_kick) rounds.front().has_force = false;
  rounds.back().keeps_force = !rounds.back().has_drift;
  return rounds;
}

template <class Real>
class FixedPointMotion final : public MovingBody {
  using Integer = kernels::Integer<Real>;
  using Force = mechanics::FixedPointForce<Real>;
  static constexpr std::int32_t nodes_per_block = Force::nodes_per_block;
  static constexpr std::int64_t steps_between_unwrapping = 16;
  /// Of rounds that follow each other in one pass over the body.
  static constexpr std::size_t forces_per_pass = 2;
  /// State and force may use the integers' range up to here; the step to the end is the overflow's alarm.
  static constexpr double limit = sizeof(Real) == 4 ? 0x1p30 : 0x1p50;

public:
  FixedPointMotion(const MotionContext& context, double load_time, double duration, MotionState& state,
                   mechanics::InstructionSet instruction_set)
      : context_(context),
        subdomain_(context.body->subdomain()),
        driven_before_(driven_kinetic(context, state)),
        reference_mass_(reference_mass(context)),
        scale_(mechanics::fixed_point_scale<Real>(range_at_start(context, load_time, duration, state))),
        kernels_(kernels::kernels<Real>(instruction_set)),
        force_(subdomain_, context.body->operators(), context.body->elasticity(), context.body->edges(),
               context.body->integrity(), relative_inverse_mass(), scale_, instruction_set),
        watch_(subdomain_, context.body->operators(), context.body->elasticity(), context.strength,
               scale_.displacement, nodes_per_block, instruction_set),
        velocity_(index(subdomain_.n_owned)),
        whole_(subdomain_.nodes.size()),
        special_(index(force_.n_blocks())),
        movement_(index(force_.n_blocks()) + n_ghost_blocks()),
        work_(start_work(load_time, state)) {
    if (context.group->size() > 1) exchange_.emplace(*context.group, subdomain_);
    if (exchange_)
      for (const auto node : exchange_->sent_nodes())
        sent_blocks_ = std::max(sent_blocks_, force_.block_of(node) + 1);
    for (const auto t : context.body->broken_tetrahedra()) watch_.retire(t);
    list_special_nodes();
  }

  void step(std::span<const Stage> stages, double time_step, double time) override {
    std::feclearexcept(FE_INVALID);
    const std::vector<Round> rounds = rounds_of(stages, time_step, time, force_is_current_);
    if (force_is_current_ && !rounds.front().has_kick) clear_forces();
    // Contact is not part of the edges' sweep, so it needs whole rounds.
    if (context_.body->has_contact()) {
      for (const Round& round : rounds) run_round(round);
    } else {
      for (std::size_t first = 0, last = 0; first < rounds.size(); first = last) {
        for (std::size_t n = 0; last < rounds.size() && n + rounds[last].has_force <= forces_per_pass; ++last)
          n += rounds[last].has_force;
        run_wavefront(std::span(rounds).subspan(first, last - first));
      }
    }
    end_exchange();
    force_is_current_ = rounds.back().keeps_force;
    n_forces_ += std::ranges::count_if(rounds, &Round::has_force);
    if (std::fetestexcept(FE_INVALID) != 0 || force_.has_overflown()) force_has_overflown_ = true;
    if (++n_steps_ % steps_between_unwrapping == 0)
      for (std::size_t i = 0; i < 3 * whole_.size(); ++i) whole_[i / 3][i % 3] = whole_displacement(i);
  }

  std::span<const std::int32_t> overloaded() override {
    overloaded_.clear();
    const auto& body = *context_.body;
    for (const auto t : watch_.suspects(force_.nodes(), movement_)) {
      if (body.is_broken(t)) continue;
      const mechanics::Symmetric sigma = body.elasticity()(strain(t));
      const double strength = context_.strength[static_cast<std::size_t>(t)];
      // The bound holds up to rounding, hence the last digits' slack.
      if (fracture::largest_principal_bound(sigma) <= strength * (1 - 1e-12)) continue;
      if (fracture::largest_principal(sigma) > strength) overloaded_.push_back(t);
    }
    std::ranges::fill(movement_, 0.0);
    return overloaded_;
  }

  /// From differences, which are exact, so that a shift of the whole body changes nothing.
  mechanics::Symmetric strain(std::int32_t number) const override {
    mechanics::TetrahedronOperator t = context_.body->operators().tetrahedra[index(number)];
    std::array<double, 12> u{};
    const auto& origin = force_.nodes()[index(t.nodes[0])].displacement;
    for (std::size_t a = 1; a < 4; ++a) {
      const auto& corner = force_.nodes()[index(t.nodes[a])].displacement;
      for (std::size_t i = 0; i < 3; ++i)
        u[3 * a + i] = scale_.displacement * static_cast<double>(kernels::difference(corner[i], origin[i]));
    }
    t.nodes = {0, 1, 2, 3};
    return mechanics::strain(t, u);
  }

  void release(std::span<const std::int32_t> broken) override {
    for (const auto t : broken) watch_.retire(t);
    force_.update(broken, force_is_current_);
    if (force_is_current_) add_contacts(n_contacts_);
    n_contacts_ = context_.body->integrity().contacts().size();
  }

  void read(MotionState& state) const override {
    const auto u = state.displacement.local();
    for (std::size_t i = 0; i < u.size(); ++i)
      u[i] = scale_.displacement * static_cast<double>(whole_displacement(i));
    const auto v = state.velocity.owned();
    for (std::size_t i = 0; i < v.size(); ++i)
      v[i] = scale_.velocity * static_cast<double>(velocity_[i / 3].value[i % 3]);
  }

  double external_work(double time, const MotionState& state) const override {
    return work_->value(time, state);
  }

  std::optional<std::string> failure() const override {
    const auto message = [&](const char* what, double quantum, const char* unit) {
      return fmt::format(
          "the {} left the range of +-{:.3g} {} that the {} number format has for this input; {}", what,
          limit * quantum, unit, sizeof(Real) == 4 ? "mixed" : "double",
          sizeof(Real) == 4 ? "set time.precision = \"double\""
                            : "the motion is unstable, or not one of small strain");
    };
    if (force_has_overflown_ || largest_force_ >= limit) return message("force on a node", scale_.force, "N");
    if (force_.largest_stretch() >= limit) return message("stretch of an edge", scale_.displacement, "m");
    for (const auto& velocity : velocity_)
      for (const Integer component : velocity.value)
        if (std::abs(static_cast<double>(component)) >= limit)
          return message("velocity of a node", scale_.velocity, "m/s");
    return {};
  }

  std::int64_t n_forces() const override { return n_forces_; }
  Traffic traffic() const override {
    if (!exchange_) return {};
    return {exchange_->n_exchanges(), exchange_->bytes_per_exchange(), exchange_seconds_};
  }

  MotionCheckpoint save() const override {
    MotionCheckpoint checkpoint;
    checkpoint.has_force = force_is_current_;
    parallel::NumberedRows local;
    local.width = force_is_current_ ? 9 : 6;
    for (std::size_t n = 0; n < velocity_.size(); ++n) {
      local.numbers.push_back(subdomain_.node_number[n]);
      for (std::size_t c = 0; c < 3; ++c) local.values.push_back(whole_displacement(3 * n + c));
      for (std::size_t c = 0; c < 3; ++c) local.values.push_back(velocity_[n].value[c]);
      for (std::size_t c = 0; c < 3 && force_is_current_; ++c)
        local.values.push_back(force_.nodes()[n].force[c]);
    }
    checkpoint.nodes = parallel::gather_rows(*context_.group, local);
    work_->save(checkpoint);
    std::vector<const std::vector<std::int32_t>*> nodes;
    std::vector<std::vector<double>> remainders;
    for (const auto& pattern : context_.loads->forces) {
      nodes.push_back(&pattern.nodes);
      remainders.emplace_back(pattern.nodes.size(), 0.0);
    }
    for (const Special& special : special_)
      for (const auto& entry : special.loaded) remainders[entry.condition][entry.place] = entry.remainder;
    checkpoint.remainder = gather_at_nodes(context_, nodes, remainders);
    checkpoint.n_steps = n_steps_;
    checkpoint.n_forces = n_forces_;
    return checkpoint;
  }

  void restore(const MotionCheckpoint& checkpoint) override {
    clear_forces();
    const auto nodes = force_.nodes();
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const auto row = checkpoint.nodes.find(subdomain_.node_number[n]);
      if (row.empty()) throw std::runtime_error("the checkpoint is of another mesh");
      for (std::size_t c = 0; c < 3; ++c) {
        whole_[n][c] = row[c];
        nodes[n].displacement[c] = static_cast<Integer>(row[c]);
        if (n >= velocity_.size()) continue;
        velocity_[n].value[c] = static_cast<Integer>(row[3 + c]);
        if (checkpoint.has_force) nodes[n].force[c] = static_cast<Integer>(row[6 + c]);
      }
    }
    force_is_current_ = checkpoint.has_force;
    work_->restore(checkpoint);
    for (Special& special : special_)
      for (auto& entry : special.loaded)
        entry.remainder =
            checkpoint.remainder.at(entry.condition).number_at(subdomain_.node_number[index(entry.node)]);
    n_steps_ = checkpoint.n_steps;
    n_forces_ = checkpoint.n_forces;
  }

private:
  /// The nodes of a block that loads act on or motions drive.
  struct Special {
    struct Entry {
      std::size_t condition;  // number of the pattern or motion
      std::size_t place;      // in its list of nodes
      std::int32_t node;
      int component;
      bool is_driven;    // of a loaded component: a motion prescribes it too
      double remainder;  // of a loaded component: what rounding has kept from the velocity so far, in quanta
      Integer velocity;  // before the kick, of driven components
    };
    std::vector<Entry> loaded;
    std::vector<Entry> driven;
  };

  static double reference_mass(const MotionContext& context) {
    double largest = 0;
    for (const double mass : context.body->operators().node_mass) largest = std::max(largest, mass);
    return std::ldexp(1.0, std::ilogb(parallel::largest_of_all(*context.group, largest)));
  }

  static mechanics::StateRange range_at_start(const MotionContext& context, double load_time, double duration,
                                              MotionState& state) {
    set_prescribed(*context.loads, load_time, state);
    state.displacement.update_ghosts();
    return expected_range(context, load_time, duration, state);
  }

  std::size_t n_ghost_blocks() const {
    return (subdomain_.nodes.size() - index(subdomain_.n_owned) + nodes_per_block - 1) / nodes_per_block;
  }

  std::vector<double> relative_inverse_mass() const {
    std::vector<double> inverse;
    for (const double mass : context_.body->operators().node_mass) inverse.push_back(reference_mass_ / mass);
    return inverse;
  }

  static Integer quantized(double value, double quantum) {
    return static_cast<Integer>(std::llrint(value / quantum));
  }

  std::optional<ExternalWork> start_work(double load_time, MotionState& state) {
    const auto nodes = force_.nodes();
    for (std::size_t i = 0; i < 3 * nodes.size(); ++i) {
      whole_[i / 3][i % 3] = std::llrint(state.displacement.local()[i] / scale_.displacement);
      nodes[i / 3].displacement[i % 3] = static_cast<Integer>(whole_[i / 3][i % 3]);
    }
    for (std::size_t i = 0; i < 3 * velocity_.size(); ++i)
      velocity_[i / 3].value[i % 3] = quantized(state.velocity.owned()[i], scale_.velocity);
    read(state);
    return ExternalWork(context_, load_time, state, driven_before_);
  }

  /// Component i % 3 of local node i / 3, with the digits that the node record has lost: those of the last
  /// unwrapping, carried on by the movement since, which is small.
  std::int64_t whole_displacement(std::size_t i) const {
    const std::int64_t last = whole_[i / 3][i % 3];
    return last + kernels::difference(force_.nodes()[i / 3].displacement[i % 3], static_cast<Integer>(last));
  }

  void list_special_nodes() {
    for (std::size_t k = 0; k < context_.loads->forces.size(); ++k) {
      const auto& pattern = context_.loads->forces[k];
      for (std::size_t n = 0; n < pattern.nodes.size(); ++n)
        special_[index(pattern.nodes[n] / nodes_per_block)].loaded.push_back(
            {k, n, pattern.nodes[n], pattern.component, false, 0, 0});
    }
    for (std::size_t m = 0; m < context_.loads->motions.size(); ++m) {
      const auto& motion = context_.loads->motions[m];
      for (std::size_t n = 0; n < motion.nodes.size(); ++n)
        special_[index(motion.nodes[n] / nodes_per_block)].driven.push_back(
            {m, n, motion.nodes[n], motion.component, true, 0, 0});
    }
    for (Special& special : special_) {
      for (auto& loaded : special.loaded) {
        loaded.is_driven = std::ranges::any_of(special.driven, [&](const auto& driven) {
          return driven.node == loaded.node && driven.component == loaded.component;
        });
      }
    }
  }

  void clear_forces() {
    for (auto& node : force_.nodes()) std::ranges::fill(node.force, Integer(0));
  }

  /// Rounds that follow each other through the body in one pass, each as closely as the edges between blocks
  /// allow: so the coefficients come from memory once for all of them. What others need is sent as soon as a
  /// round has moved it, and waited for only where the next round cannot do without.
  /// @param rounds none but the first may lack a force
  void run_wavefront(std::span<const Round> rounds) {
    const std::int32_t n = force_.n_blocks();
    std::vector<std::int32_t> next_force(rounds.size(), 0), next_update(rounds.size(), 0);
    for (std::size_t r = 0; r < rounds.size(); ++r)
      if (!rounds[r].has_force) next_force[r] = n;
    const auto is_ready = [&](std::size_t r) {
      const auto& reach = force_.reach(next_force[r]);
      if (r == 0) return true;
      if (reach.last_owned >= next_update[r - 1]) return false;
      // A block next to ghosts has nodes that are ghosts elsewhere, so the round before is through with the
      // ghosts' former values.
      return !reach.has_ghosts || next_update[r - 1] >= sent_blocks_;
    };
    const auto update = [&](std::size_t r) {
      update_nodes(next_update[r]++, rounds[r]);
      if (rounds[r].has_drift && next_update[r] == sent_blocks_) begin_exchange();
    };
    while (next_update.back() < n) {
      for (std::size_t r = 0; r < rounds.size(); ++r) {
        const std::int32_t n_movable = r == 0 ? n : next_update[r - 1];
        if (!rounds[r].has_force) {
          if (next_update[r] < n_movable) update(r);
          continue;
        }
        if (next_force[r] < n && is_ready(r)) {
          if (force_.reach(next_force[r]).has_ghosts) end_exchange();
          force_.add_block(next_force[r]++);
        }
        while (next_update[r] < n_movable &&
               (next_force[r] == n || force_.last_toucher(next_update[r]) < next_force[r])) {
          update(r);
        }
      }
    }
  }

  void run_round(const Round& round) {
    if (round.has_force) {
      for (std::int32_t b = 0; b < force_.n_blocks(); ++b) {
        if (force_.reach(b).has_ghosts) end_exchange();
        force_.add_block(b);
      }
      add_contacts(0);
    }
    for (std::int32_t b = 0; b < force_.n_blocks(); ++b) update_nodes(b, round);
    if (round.has_drift) begin_exchange();
  }

  /// What closed cuts from number `first` on hand on, tetrahedron by tetrahedron; corner 0 takes what the
  /// others leave, so that the sum is exactly 0.
  void add_contacts(std::size_t first) {
    const auto& integrity = context_.body->integrity();
    const auto nodes = force_.nodes();
    for (std::size_t c = first; c < integrity.contacts().size(); ++c) {
      const auto number = integrity.contacts()[c];
      const mechanics::Symmetric sigma = integrity.contact_stress(c, strain(number));
      if (sigma == mechanics::Symmetric{}) continue;
      const auto& t = context_.body->operators().tetrahedra[index(number)];
      for (std::size_t a = 1; a < 4; ++a) {
        const auto traction = mechanics::apply(sigma, t.gradient[a]);
        for (std::size_t i = 0; i < 3; ++i) {
          const auto force = quantized(t.volume * traction[i], scale_.force);
          // A force out of range is noticed when the nodes are moved.
          auto& one = nodes[index(t.nodes[a])].force[i];
          auto& other = nodes[index(t.nodes[0])].force[i];
          one = kernels::sum(one, force);
          other = kernels::difference(other, force);
        }
      }
    }
  }

  void begin_exchange() {
    if (!exchange_) return;
    end_exchange();
    const Stopwatch watch;
    const auto nodes = force_.nodes();
    const auto sent = exchange_->sent_nodes();
    for (std::size_t i = 0; i < sent.size(); ++i)
      std::copy_n(nodes[index(sent[i])].displacement, 3, exchange_->sent()[i].begin());
    exchange_->begin();
    exchange_is_under_way_ = true;
    exchange_seconds_ += watch.seconds();
  }

  void end_exchange() {
    if (!exchange_is_under_way_) return;
    const Stopwatch watch;
    exchange_->end();
    exchange_is_under_way_ = false;
    exchange_seconds_ += watch.seconds();
    const auto ghosts = force_.nodes().subspan(index(subdomain_.n_owned));
    const auto received = exchange_->received();
    for (std::size_t begin = 0; begin < ghosts.size(); begin += nodes_per_block) {
      double furthest = 0;
      for (std::size_t i = begin; i < std::min(begin + nodes_per_block, ghosts.size()); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          furthest = std::max(
              furthest,
              std::abs(static_cast<double>(kernels::difference(received[i][c], ghosts[i].displacement[c]))));
          ghosts[i].displacement[c] = received[i][c];
        }
      }
      movement_[index(force_.n_blocks()) + begin / nodes_per_block] += furthest;
    }
  }

  void update_nodes(std::int32_t block, const Round& round) {
    const auto first = index(force_.first_node(block));
    const std::size_t n = std::min(velocity_.size() - first, index(nodes_per_block));
    kernels::NodeRecord<Real>* const nodes = force_.nodes().data() + first;
    kernels::Velocity<Real>* const velocity = velocity_.data() + first;
    Special& special = special_[first / nodes_per_block];
    if (round.has_kick) {
      for (auto& entry : special.driven) prepare_driven(entry, round);
      const auto factor = static_cast<Real>(-round.kick * scale_.force / (scale_.velocity * reference_mass_));
      const Real largest = kernels_.kick(nodes, velocity, n, factor, round.keeps_force);
      if (!(static_cast<double>(largest) <= largest_force_)) largest_force_ = static_cast<double>(largest);
      for (const auto& entry : special.driven)
        velocity_[index(entry.node)].value[entry.component] = entry.velocity;
      for (auto& entry : special.loaded) kick_by_load(entry, round);
    }
    if (round.has_drift) {
      const auto factor = static_cast<Real>(round.drift * scale_.velocity / scale_.displacement);
      double furthest = static_cast<double>(kernels_.drift(nodes, velocity, n, factor)) + 1;
      for (const auto& entry : special.driven) furthest = std::max(furthest, drive(entry, round));
      movement_[first / nodes_per_block] += furthest;
    }
  }

  void prepare_driven(typename Special::Entry& entry, const Round& round) {
    entry.velocity = velocity_[index(entry.node)].value[entry.component];
    const double velocity = context_.loads->motions[entry.condition].velocity(round.kick_time);
    if (velocity == 0) return;
    const auto force = force_.nodes()[index(entry.node)].force[entry.component];
    work_->add_reaction(entry.condition, entry.place, round.kick * velocity,
                        scale_.force * static_cast<double>(force));
  }

  void kick_by_load(typename Special::Entry& entry, const Round& round) {
    const auto& pattern = context_.loads->forces[entry.condition];
    const double u =
        scale_.displacement * static_cast<double>(whole_displacement(
                                  3 * index(entry.node) + static_cast<std::size_t>(entry.component)));
    work_->add_rate(entry.condition, entry.place, round.kick * pattern.amplitude.slope(round.kick_time), u);
    if (entry.is_driven) return;
    const double mass = context_.body->operators().node_mass[index(entry.node)];
    const double force = pattern.amplitude.at(round.kick_time) * pattern.weight[entry.place];
    // A constant load would be rounded the same way in every kick: the remainder is carried on.
    const double change = round.kick * force / mass / scale_.velocity + entry.remainder;
    const auto rounded = static_cast<Integer>(std::llrint(change));
    entry.remainder = change - static_cast<double>(rounded);
    auto& velocity = velocity_[index(entry.node)].value[entry.component];
    velocity = kernels::sum(velocity, rounded);
  }

  /// @return the way that the drive added, in quanta
  double drive(const typename Special::Entry& entry, const Round& round) {
    const auto& motion = context_.loads->motions[entry.condition];
    auto& place = force_.nodes()[index(entry.node)].displacement[entry.component];
    const Integer before = place;
    place = static_cast<Integer>(std::llrint(motion.displacement(round.drift_time) / scale_.displacement));
    velocity_[index(entry.node)].value[entry.component] =
        quantized(motion.velocity(round.drift_time), scale_.velocity);
    // The drift went by factor times velocity from where the step began; together they are below the sum.
    return std::abs(static_cast<double>(kernels::difference(place, before))) +
           std::abs(round.drift * motion.velocity(round.drift_time)) / scale_.displacement + 2;
  }

  MotionContext context_;
  const geometry::Subdomain& subdomain_;
  std::vector<double> driven_before_;
  double reference_mass_;
  mechanics::FixedPointScale scale_;
  const kernels::Kernels<Real>& kernels_;
  Force force_;
  fracture::StressWatch<Real> watch_;
  std::optional<parallel::GhostExchange<Integer>> exchange_;
  std::vector<kernels::Velocity<Real>> velocity_;
  std::vector<std::array<std::int64_t, 3>> whole_;  // displacements at the last unwrapping, of local nodes
  std::vector<Special> special_;
  std::vector<double> movement_;  // of each block of nodes since the last breaking check, in quanta
  std::optional<ExternalWork> work_;
  std::vector<std::int32_t> overloaded_;
  bool force_is_current_ = false;
  std::size_t n_contacts_ = 0;    // that the nodes' forces know of
  std::int32_t sent_blocks_ = 1;  // behind the last block of nodes that are ghosts elsewhere
  bool exchange_is_under_way_ = false;
  bool force_has_overflown_ = false;
  double largest_force_ = 0;
  std::int64_t n_steps_ = 0;
  std::int64_t n_forces_ = 0;
  double exchange_seconds_ = 0;
};

}  // namespace

std::unique_ptr<MovingBody> make_fixed_point_motion(const MotionContext& context, input::Precision precision,
                                                    double load_time, double duration, MotionState& state,
                                                    mechanics::InstructionSet instruction_set) {
  if (precision == input::Precision::mixed)
    return std::make_unique<FixedPointMotion<float>>(context, load_time, duration, state, instruction_set);
  return std::make_unique<FixedPointMotion<double>>(context, load_time, duration, state, instruction_set);
}

}  // namespace crackle::dynamics
