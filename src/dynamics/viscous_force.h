// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "geometry/subdomain.h"
#include "input/model.h"
#include "mechanics/elasticity.h"
#include "mechanics/operators.h"
#include "mechanics/residual_stiffness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Bulk viscosity (von Neumann and Richtmyer 1950; as in Abaqus/Explicit and LS-DYNA): in each intact
/// tetrahedron the pressure -(b1 + b2^2 min(-L e / c, 0.01)) rho c L e against the rate e of its volumetric
/// strain, where the quadratic term, b2, acts in compression only; L is the cube root of its volume, c the
/// dilatational speed. It enters neither the stress nor the criterion. The bound on the quadratic term, which
/// only waves of more than 1 % of strain reach, is what a fixed time step can be stable with.
///
/// The rate is the mean over the last time step, at whose end the force acts for as long as a step: in
/// Verlet's scheme that is the velocity at half a step, as in central differences. Nothing here is
/// collective.
class ViscousForce {
public:
  /// Of all local tetrahedra; none if the coefficients are 0.
  ViscousForce(const geometry::Subdomain& subdomain, const mechanics::PdsOperators& operators,
               const mechanics::MaterialField& material, const input::BulkViscosity& coefficients);

  /// The force at the nodes, by which the velocity changes as by minus an internal force.
  /// @param moved difference between the movements of two nodes over the step, by component [m]
  /// @param convert turns a force [N] into a number; corner 0 of a tetrahedron balances the others exactly
  /// @param add adds such a number to the force on a local node, ghosts included
  template <class Moved, class Convert, class Add>
  void find(const mechanics::ResidualStiffness& stiffness, double duration, const Moved& moved,
            const Convert& convert, const Add& add) const {
    for (std::size_t t = 0; t < cells_.size(); ++t) {
      if (!stiffness.is_intact(static_cast<std::int32_t>(t))) continue;
      const Cell& cell = cells_[t];
      double change = 0;
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t i = 0; i < 3; ++i)
          change += static_cast<double>(cell.gradient[a][i]) * moved(cell.nodes[a + 1], cell.nodes[0], i);
      const double rate = change / duration;
      add_cell(cell, coefficient(-rate * cell.transit) * cell.impedance * rate, convert, add);
    }
  }

  /// Adds the largest force that it may have at some velocities, times a factor.
  /// @param velocity, force 3 n_local
  void add_largest(double factor, std::span<const double> velocity, std::span<double> force) const;

private:
  struct Cell {
    geometry::Tetrahedron nodes;
    std::array<std::array<float, 3>, 3> gradient;  ///< of corners 1 to 3 [1/m]
    double impedance;                              ///< volume times rho c L [kg m^2/s]
    double transit;                                ///< L / c [s]
  };

  /// The largest strain rate that counts in the quadratic term, as a strain over the way of a wave across L.
  static constexpr double greatest_strain = 0.01;

  double coefficient(double compression) const {
    return linear_ + square_ * std::clamp(compression, 0.0, greatest_strain);
  }

  /// @param pressure negative, times the volume [J]
  template <class Convert, class Add>
  static void add_cell(const Cell& cell, double pressure, const Convert& convert, const Add& add) {
    for (std::size_t i = 0; i < 3; ++i) {
      decltype(convert(0.0)) sum{};
      for (std::size_t a = 0; a < 3; ++a) {
        const auto force = convert(pressure * static_cast<double>(cell.gradient[a][i]));
        add(cell.nodes[a + 1], i, force);
        sum += force;
      }
      add(cell.nodes[0], i, -sum);
    }
  }

  double linear_, square_;
  std::vector<Cell> cells_;
};

}  // namespace crackle::dynamics
