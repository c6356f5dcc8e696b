// SPDX-License-Identifier: GPL-3.0-or-later
#include "condition_terms.h"

#include "common/index.h"
#include "mechanics/node_cells.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace crackle::dynamics {

namespace {

/// Values at the nodes of conditions, one list per condition, as tables gathered on the root. Collective.
std::vector<parallel::NumberedRows> gather_at_nodes(const MotionContext& context, const auto& conditions,
                                                    const std::vector<std::vector<double>>& values) {
  std::vector<parallel::NumberedRows> tables;
  for (std::size_t k = 0; k < values.size(); ++k) {
    parallel::NumberedRows local;
    for (std::size_t n = 0; n < values[k].size(); ++n)
      local.add(context.body->subdomain().layout.number[index(conditions[k].nodes[n])], values[k][n]);
    tables.push_back(parallel::gather_rows(*context.group, local));
  }
  return tables;
}

/// Reads what gather_at_nodes() has gathered, from the table `first` on.
void take_out(const MotionContext& context, const auto& conditions,
              const std::vector<parallel::NumberedRows>& tables, std::size_t first,
              std::vector<std::vector<double>>& values) {
  if (tables.size() < first + values.size())
    throw std::runtime_error("the checkpoint has a different number of boundary conditions");
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t n = 0; n < values[k].size(); ++n)
      values[k][n] =
          tables[first + k].number_at(context.body->subdomain().layout.number[index(conditions[k].nodes[n])]);
}

/// A value of 0 at each node of the conditions.
std::vector<std::vector<double>> zero_at_nodes(const auto& conditions) {
  std::vector<std::vector<double>> values;
  for (const auto& one : conditions) values.emplace_back(one.nodes.size(), 0.0);
  return values;
}

/// The nodes of all conditions by blocks.
template <class Entry>
std::vector<std::vector<Entry>> entries(const MotionContext& context, const auto& conditions,
                                        std::int32_t nodes_per_block) {
  const auto n_owned = context.body->subdomain().layout.n_owned;
  std::vector<std::vector<Entry>> blocks(
      index(std::max(1, (n_owned + nodes_per_block - 1) / nodes_per_block)));
  for (std::size_t k = 0; k < conditions.size(); ++k)
    for (std::size_t n = 0; n < conditions[k].nodes.size(); ++n)
      blocks[index(conditions[k].nodes[n] / nodes_per_block)].push_back(
          Entry{static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(n)});
  return blocks;
}

/// Largest magnitude of a load curve's quantity between two times: at the ends and at the kinks between.
template <class Quantity>
double peak(const mechanics::LoadCurve& curve, double from, double to, const Quantity& quantity) {
  double largest = std::max(std::abs(quantity(from)), std::abs(quantity(to)));
  for (double t = curve.next_kink(from); t < to; t = curve.next_kink(t))
    largest = std::max(largest, std::abs(quantity(t)));
  return largest;
}

double peak_of(const mechanics::ForcePattern& pattern, double from, double to) {
  return peak(pattern.amplitude, from, to, [&](double t) { return pattern.amplitude.at(t); });
}

double component_of(const parallel::NodeField& field, std::int32_t node, int component) {
  return field.owned()[index(node, component)];
}

}  // namespace

LoadTerm::LoadTerm(const MotionContext& context, std::int32_t nodes_per_block)
    : context_(context),
      blocks_(entries<Entry>(context, context.loads->forces, nodes_per_block)),
      rate_work_(zero_at_nodes(context.loads->forces)) {}

void LoadTerm::start(double time, const MotionState& state) {
  add_potential(time, state, start_);
}

void LoadTerm::after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  std::optional<std::uint32_t> current;
  double amplitude = 0, slope = 0;
  for (Entry& entry : blocks_[block]) {
    const mechanics::ForcePattern& pattern = context_.loads->forces[entry.pattern];
    if (current != entry.pattern) {
      current = entry.pattern;
      amplitude = pattern.amplitude.at(substep.kick_time);
      slope = pattern.amplitude.slope(substep.kick_time, substep.step);
    }
    if (!pattern.does_work_at(entry.place)) continue;
    const std::int32_t node = pattern.nodes[entry.place];
    // The amplitude changes at constant displacement.
    if (slope != 0)
      rate_work_[entry.pattern][entry.place] +=
          substep.kick * slope * pattern.weight[entry.place] * nodes.displacement(node, pattern.component);
    nodes.kick(node, pattern.component, substep.kick, amplitude * pattern.weight[entry.place],
               entry.remainder);
  }
}

void LoadTerm::add_potential(double time, const MotionState& state, std::vector<double>& sum) const {
  for (const auto& pattern : context_.loads->forces) {
    const double amplitude = pattern.amplitude.at(time);
    for (std::size_t n = 0; n < pattern.nodes.size(); ++n)
      if (pattern.does_work_at(n))
        sum.push_back(amplitude * pattern.weight[n] *
                      component_of(state.displacement, pattern.nodes[n], pattern.component));
  }
}

void LoadTerm::add_supplied(double time, const MotionState& state, std::vector<double>& sum) const {
  add_potential(time, state, sum);
  for (const double potential : start_) sum.push_back(-potential);
  for (const auto& works : rate_work_)
    for (const double work : works) sum.push_back(-work);
}

void LoadTerm::end_loads(double time, const mechanics::NodesOfConditions& nodes,
                         const parallel::NodeField& displacement) {
  for (std::size_t k = 0; k < rate_work_.size(); ++k) {
    const auto& pattern = context_.loads->forces[k];
    const double amplitude = pattern.amplitude.at(time);
    for (std::size_t n = 0; n < pattern.nodes.size(); ++n)
      if (pattern.does_work_at(n) &&
          std::ranges::binary_search(nodes[index(pattern.condition)], pattern.nodes[n]))
        rate_work_[k][n] -=
            amplitude * pattern.weight[n] * component_of(displacement, pattern.nodes[n], pattern.component);
  }
}

Demand LoadTerm::demand(double from, double to) const {
  const fracture::BreakableBody& body = *context_.body;
  const auto& node_mass = body.operators().node_mass;
  parallel::check_peers(*context_.group);
  const double heaviest =
      parallel::largest_of_all(*context_.group, std::ranges::max(body.material().density.values()));
  const geometry::Box box = mechanics::box_of_all(*context_.group, body.subdomain());
  const double extent = std::ranges::max(box.upper - box.lower);
  Demand demand;
  for (const auto& pattern : context_.loads->forces) {
    const double amplitude = peak_of(pattern, from, to);
    double acceleration = 0;
    for (std::size_t n = 0; n < pattern.nodes.size(); ++n) {
      const double mass = node_mass[index(pattern.nodes[n])];
      const double force = amplitude * std::abs(pattern.weight[n]), volume = mass / heaviest;
      // A body force adds up along the whole body.
      demand.stress = std::max(demand.stress, pattern.is_body_force ? force / volume * extent
                                                                    : force / std::pow(volume, 2.0 / 3.0));
      acceleration = std::max(acceleration, std::abs(pattern.weight[n]) / mass);
    }
    demand.resultant += std::abs(pattern.total_weight) * amplitude;
    if (!pattern.is_body_force) continue;
    parallel::check_peers(*context_.group);
    demand.acceleration += amplitude * parallel::largest_of_all(*context_.group, acceleration);
  }
  parallel::check_peers(*context_.group);
  demand.stress = parallel::largest_of_all(*context_.group, demand.stress);
  return demand;
}

void LoadTerm::add_unit_loads(std::vector<UnitLoad>& loads) const {
  for (const auto& pattern : context_.loads->forces)
    loads.push_back({UnitLoad::Kind::force, &pattern.amplitude,
                     [&](std::span<double> force) {
                       for (std::size_t n = 0; n < pattern.nodes.size(); ++n)
                         force[index(pattern.nodes[n], pattern.component)] = pattern.weight[n];
                     },
                     pattern.total_weight});
}

void LoadTerm::measure(double time, const parallel::NodeField& displacement, const parallel::NodeField*,
                       LoadState& state) const {
  measure_forces(*context_.group, *context_.loads, displacement, time, state);
}

std::vector<parallel::NumberedRows> LoadTerm::save() const {
  auto remainders = zero_at_nodes(context_.loads->forces);
  for (const auto& block : blocks_)
    for (const Entry& entry : block) remainders[entry.pattern][entry.place] = entry.remainder;
  auto tables = gather_at_nodes(context_, context_.loads->forces, rate_work_);
  for (auto& table : gather_at_nodes(context_, context_.loads->forces, remainders))
    tables.push_back(std::move(table));
  return tables;
}

void LoadTerm::restore(const std::vector<parallel::NumberedRows>& rows) {
  auto remainders = zero_at_nodes(context_.loads->forces);
  take_out(context_, context_.loads->forces, rows, 0, rate_work_);
  take_out(context_, context_.loads->forces, rows, rate_work_.size(), remainders);
  for (auto& block : blocks_)
    for (Entry& entry : block) entry.remainder = remainders[entry.pattern][entry.place];
}

MotionTerm::MotionTerm(const MotionContext& context, const MotionState& given, std::int32_t nodes_per_block)
    : context_(context),
      blocks_(entries<Entry>(context, context.loads->motions, nodes_per_block)),
      work_(zero_at_nodes(context.loads->motions)) {
  add_driven_kinetic(given, start_);
}

void MotionTerm::prescribe(double time, MotionState& state) const {
  context_.loads->set_displacements(time, state.displacement.owned());
  for (const auto& motion : context_.loads->motions) {
    const double velocity = motion.velocity(time);
    for (std::size_t i = 0; i < motion.nodes.size(); ++i)
      state.velocity.owned()[index(motion.nodes[i], motion.component)] = motion.factor_at(i) * velocity;
  }
}

void MotionTerm::before_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  for (Entry& entry : blocks_[block]) {
    const mechanics::PrescribedMotion& motion = context_.loads->motions[entry.motion];
    const std::int32_t node = motion.nodes[entry.place];
    entry.velocity = nodes.velocity(node, motion.component);
    const double prescribed =
        motion.factor_at(entry.place) * motion.velocity(substep.kick_time, substep.step);
    if (prescribed == 0) continue;
    work_[entry.motion][entry.place] +=
        substep.kick * prescribed * nodes.internal_force(node, motion.component);
  }
}

void MotionTerm::after_kick(std::size_t block, const Substep&, MovingNodes& nodes) {
  for (const Entry& entry : blocks_[block]) {
    const mechanics::PrescribedMotion& motion = context_.loads->motions[entry.motion];
    nodes.set_velocity(motion.nodes[entry.place], motion.component, entry.velocity);
  }
}

void MotionTerm::after_drift(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  for (const Entry& entry : blocks_[block]) {
    const mechanics::PrescribedMotion& motion = context_.loads->motions[entry.motion];
    const double factor = motion.factor_at(entry.place);
    nodes.drive(motion.nodes[entry.place], motion.component, factor * motion.displacement(substep.drift_time),
                factor * motion.velocity(substep.drift_time), substep.drift);
  }
}

void MotionTerm::move_against(const mechanics::StepSpan& step, const Resistance& resistance) {
  const double duration = step.end - step.begin;
  for (std::size_t m = 0; m < context_.loads->motions.size(); ++m) {
    const auto& motion = context_.loads->motions[m];
    const double speed = motion.velocity(step.end, step);
    for (std::size_t n = 0; n < motion.nodes.size(); ++n) {
      const double displacement = duration * motion.factor_at(n) * speed;
      work_[m][n] += displacement * resistance(motion.nodes[n], motion.component, displacement);
    }
  }
}

void MotionTerm::add_driven_kinetic(const MotionState& state, std::vector<double>& sum) const {
  for (const auto& motion : context_.loads->motions) {
    for (const auto node : motion.nodes) {
      const double v = component_of(state.velocity, node, motion.component);
      sum.push_back(0.5 * context_.body->operators().node_mass[index(node)] * v * v);
    }
  }
}

void MotionTerm::add_supplied(double, const MotionState& state, std::vector<double>& sum) const {
  for (const double kinetic : start_) sum.push_back(-kinetic);
  for (const auto& works : work_) sum.insert(sum.end(), works.begin(), works.end());
  add_driven_kinetic(state, sum);
}

Demand MotionTerm::demand(double from, double to) const {
  Demand demand{.holds = !context_.loads->motions.empty()};
  for (const auto& motion : context_.loads->motions) {
    double factor = 0;
    for (std::size_t n = 0; n < motion.nodes.size(); ++n)
      factor = std::max(factor, std::abs(motion.factor_at(n)));
    demand.velocity = std::max(
        demand.velocity, factor * peak(motion.curve, from, to, [&](double t) { return motion.velocity(t); }));
  }
  parallel::check_peers(*context_.group);
  demand.velocity = parallel::largest_of_all(*context_.group, demand.velocity);
  return demand;
}

void MotionTerm::add_unit_loads(std::vector<UnitLoad>& loads) const {
  for (const auto& motion : context_.loads->motions)
    if (!motion.never_moves())
      loads.push_back({UnitLoad::Kind::motion, &motion.curve,
                       [&](std::span<double> displacement) {
                         for (std::size_t n = 0; n < motion.nodes.size(); ++n)
                           displacement[index(motion.nodes[n], motion.component)] = motion.factor_at(n);
                       },
                       0, motion.is_velocity});
}

void MotionTerm::mark_held(std::span<std::uint8_t> held) const {
  for (const auto& motion : context_.loads->motions)
    for (const auto node : motion.nodes) held[index(node, motion.component)] = 1;
}

void MotionTerm::measure(double time, const parallel::NodeField& displacement, const parallel::NodeField*,
                         LoadState& state) const {
  measure_motions(*context_.group, *context_.body, *context_.loads, displacement, time, state);
}

std::vector<parallel::NumberedRows> MotionTerm::save() const {
  return gather_at_nodes(context_, context_.loads->motions, work_);
}

void MotionTerm::restore(const std::vector<parallel::NumberedRows>& rows) {
  take_out(context_, context_.loads->motions, rows, 0, work_);
}

void InitialStrainTerm::add_unit_loads(std::vector<UnitLoad>& loads) const {
  for (const auto& part : context_.body->initial_strain().parts())
    loads.push_back({UnitLoad::Kind::strain, &part.factor, [&, this](std::span<double> force) {
                       context_.body->force().evaluate_strains(part.strain, force);
                     }});
}

void InitialStrainTerm::measure(double, const parallel::NodeField& displacement, const parallel::NodeField*,
                                LoadState& state) const {
  measure_initial_strain(*context_.group, *context_.body, displacement, state);
}

}  // namespace crackle::dynamics
