// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "dynamics/moving_body.h"
#include "dynamics/term.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace crackle::test {

/// Springs on the area of a boundary condition, along one axis.
struct SpringBed {
  /// How they push back: always; likewise, but loads have to grow in increments; or only what comes closer
  /// than the gap.
  enum class Kind { linear, in_increments, one_sided };
  Kind kind = Kind::linear;
  std::size_t condition = 0;
  int component = 2;
  double side = 1;       ///< 1: against displacements along the axis; -1: against those the other way
  double stiffness = 0;  ///< of all springs together [N/m]
  double gap = 0;        ///< [m]
  /// In equilibrium their feet approach by this curve [m]; they must not be linear then.
  mechanics::LoadCurve approach = {};
};

/// A contribution to the motion that the program does not know.
class Springs final : public dynamics::Term {
public:
  Springs(const dynamics::MotionContext& context, const SpringBed& bed, std::int32_t nodes_per_block)
      : context_(context), bed_(bed), nodes_per_block_(nodes_per_block), remainder_(nodes().size()) {}

  bool acts_on(std::size_t block) const override {
    return std::ranges::any_of(nodes(), [&](std::int32_t node) { return block_of(node) == block; });
  }
  void after_kick(std::size_t block, const dynamics::Substep& substep,
                  dynamics::MovingNodes& moving) override {
    for (std::size_t n = 0; n < nodes().size(); ++n)
      if (block_of(nodes()[n]) == block)
        moving.kick(nodes()[n], bed_.component, substep.kick,
                    force(n, moving.displacement(nodes()[n], bed_.component), 0), remainder_[n]);
  }
  dynamics::Demand demand(double, double) const override { return {.holds = true}; }
  bool stores() const override { return true; }
  void add_stored(const parallel::NodeField& displacement, std::vector<double>& sum) const override {
    for (std::size_t n = 0; n < nodes().size(); ++n) {
      const double u = displacement.owned()[index(nodes()[n], bed_.component)];
      sum.push_back(-0.5 * force(n, u, time_) * bed_.side * (bed_.side * u - gap(time_)));
    }
  }

  bool is_linear() const override { return bed_.kind == SpringBed::Kind::linear; }
  void add_unit_loads(std::vector<dynamics::UnitLoad>& loads) const override {
    if (!is_linear()) loads.push_back({dynamics::UnitLoad::Kind::other, &bed_.approach});
  }
  void rest_at(double time, const parallel::NodeField&) override { time_ = time; }
  void add_responses(double time, std::span<const double> displacement,
                     std::vector<dynamics::NodeResponse>& responses) const override {
    for (std::size_t n = 0; n < nodes().size(); ++n) {
      dynamics::NodeResponse response;
      const double u = displacement[index(nodes()[n], bed_.component)];
      response.node = nodes()[n];
      response.force[index(bed_.component)] = force(n, u, time);
      response.stiffness[index(bed_.component)] = acts(u, time) ? stiffness(n) : 0;
      responses.push_back(response);
    }
  }
  void add_stiffest(std::span<const double>, std::vector<dynamics::NodeResponse>& most) const override {
    for (std::size_t n = 0; n < nodes().size(); ++n) {
      dynamics::NodeResponse response;
      response.node = nodes()[n];
      response.stiffness[index(bed_.component)] = stiffness(n);
      most.push_back(response);
    }
  }
  void add_supports(std::vector<mechanics::Support>& supports) const override {
    for (const auto node : nodes())
      supports.push_back({node, static_cast<std::uint8_t>(1 << bed_.component)});
  }

  void measure(double time, const parallel::NodeField& displacement, const parallel::NodeField* velocity,
               dynamics::LoadState& state) const override {
    const double at = velocity == nullptr ? time : 0;
    std::vector<double> forces;
    for (std::size_t n = 0; n < nodes().size(); ++n)
      forces.push_back(force(n, displacement.owned()[index(nodes()[n], bed_.component)], at));
    const double whole = parallel::exact_sum(*context_.group, forces);
    if (velocity == nullptr) state.works.push_back({whole, -bed_.side * bed_.approach.at(at), true});
    state.records.push_back({"springs", "N", "force of the springs on the body", whole});
  }

  std::vector<parallel::NumberedRows> save() const override {
    parallel::NumberedRows local;
    for (std::size_t n = 0; n < nodes().size(); ++n) local.add(number(n), remainder_[n]);
    return {parallel::gather_rows(*context_.group, local)};
  }
  void restore(const std::vector<parallel::NumberedRows>& rows) override {
    for (std::size_t n = 0; n < nodes().size(); ++n) remainder_[n] = rows.at(0).number_at(number(n));
  }

private:
  const mechanics::ConditionNodes& place() const { return context_.loads->conditions[bed_.condition]; }
  const std::vector<std::int32_t>& nodes() const { return place().nodes; }
  std::size_t block_of(std::int32_t node) const { return index(node / nodes_per_block_); }
  std::int64_t number(std::size_t n) const {
    return context_.body->subdomain().layout.number[index(nodes()[n])];
  }
  double gap(double time) const { return bed_.gap - bed_.approach.at(time); }
  bool acts(double u, double time) const {
    return bed_.kind != SpringBed::Kind::one_sided || bed_.side * u >= gap(time);
  }
  double stiffness(std::size_t n) const { return bed_.stiffness * place().share[n]; }
  double force(std::size_t n, double u, double time) const {
    return acts(u, time) ? -stiffness(n) * bed_.side * (bed_.side * u - gap(time)) : 0;
  }

  dynamics::MotionContext context_;
  SpringBed bed_;
  std::int32_t nodes_per_block_;
  std::vector<double> remainder_;
  double time_ = 0;  // of the last equilibrium
};

inline dynamics::MakeTerm make_springs(const SpringBed& bed) {
  return [bed](const dynamics::MotionContext& context, const dynamics::MotionState&,
               std::int32_t nodes_per_block) {
    return std::make_unique<Springs>(context, bed, nodes_per_block);
  };
}

}  // namespace crackle::test
