// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/moving_body.h"
#include "dynamics/term.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// The force patterns of the conditions.
///
/// A splitting conserves, to its order, T + U - F(t).u + the sum over kicks of F'(t).u dt. The work supplied
/// is the external part of that sum, so that the energy balance closes to the integrator's order for any load
/// curve.
class LoadTerm final : public Term {
public:
  /// The context's members must outlive the object.
  LoadTerm(const MotionContext& context, std::int32_t nodes_per_block);

  void start(double time, const MotionState& state) override;
  bool acts_on(std::size_t block) const override { return !blocks_[block].empty(); }
  void after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) override;
  void add_supplied(double time, const MotionState& state, std::vector<double>& sum) const override;
  void end_loads(double time, const mechanics::NodesOfConditions& nodes,
                 const parallel::NodeField& displacement) override;
  Demand demand(double from, double to) const override;
  void add_unit_loads(std::vector<UnitLoad>& loads) const override;
  void measure(double time, const parallel::NodeField& displacement, const parallel::NodeField* velocity,
               LoadState& state) const override;
  std::vector<parallel::NumberedRows> save() const override;
  void restore(const std::vector<parallel::NumberedRows>& rows) override;

private:
  /// A node of a pattern.
  struct Entry {
    std::uint32_t pattern;
    std::uint32_t place;  // in its list of nodes
    double remainder = 0;
  };

  void add_potential(double time, const MotionState& state, std::vector<double>& sum) const;

  MotionContext context_;
  std::vector<std::vector<Entry>> blocks_;      // those of a pattern follow each other
  std::vector<std::vector<double>> rate_work_;  // by pattern and node: of the kicks
  std::vector<double> start_;                   // potential at the start
};

/// The prescribed motions of the conditions. The work supplied is that of the internal forces on them, and
/// their kinetic energy.
class MotionTerm final : public Term {
public:
  /// The context's members must outlive the object.
  /// @param given the state before prescribe()
  MotionTerm(const MotionContext& context, const MotionState& given, std::int32_t nodes_per_block);

  void prescribe(double time, MotionState& state) const override;
  bool acts_on(std::size_t block) const override { return !blocks_[block].empty(); }
  void before_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) override;
  void after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) override;
  void after_drift(std::size_t block, const Substep& substep, MovingNodes& nodes) override;
  void move_against(const mechanics::StepSpan& step, const Resistance& resistance) override;
  void add_supplied(double time, const MotionState& state, std::vector<double>& sum) const override;
  Demand demand(double from, double to) const override;
  void add_unit_loads(std::vector<UnitLoad>& loads) const override;
  void measure(double time, const parallel::NodeField& displacement, const parallel::NodeField* velocity,
               LoadState& state) const override;
  void mark_held(std::span<std::uint8_t> held) const override;
  std::vector<parallel::NumberedRows> save() const override;
  void restore(const std::vector<parallel::NumberedRows>& rows) override;

private:
  /// A node of a motion.
  struct Entry {
    std::uint32_t motion;
    std::uint32_t place;  // in its list of nodes
    double velocity = 0;  // before the kick, which must not change it
  };

  void add_driven_kinetic(const MotionState& state, std::vector<double>& sum) const;

  MotionContext context_;
  std::vector<std::vector<Entry>> blocks_;
  std::vector<std::vector<double>> work_;  // by motion and node: of the internal force
  std::vector<double> start_;              // kinetic energy in the given state
};

/// The initial strain of a body at rest. In motion it is constant, and part of the body's internal force.
class InitialStrainTerm final : public Term {
public:
  /// The context's members must outlive the object.
  explicit InitialStrainTerm(const MotionContext& context) : context_(context) {}

  void add_unit_loads(std::vector<UnitLoad>& loads) const override;
  void measure(double time, const parallel::NodeField& displacement, const parallel::NodeField* velocity,
               LoadState& state) const override;

private:
  MotionContext context_;
};

}  // namespace crackle::dynamics
