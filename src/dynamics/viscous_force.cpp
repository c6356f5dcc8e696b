// SPDX-License-Identifier: GPL-3.0-or-later
#include "viscous_force.h"

namespace crackle::dynamics {

ViscousForce::ViscousForce(const geometry::Subdomain& subdomain, const mechanics::PdsOperators& operators,
                           const mechanics::MaterialField& material, const input::BulkViscosity& coefficients)
    : linear_(coefficients.linear), square_(coefficients.quadratic * coefficients.quadratic) {
  if (!coefficients.acts()) return;
  cells_.reserve(subdomain.tetrahedra.size());
  for (std::int32_t number = 0; number < subdomain.n_tetrahedra(); ++number) {
    const mechanics::TetrahedronOperator t = operators.tetrahedra[index(number)];
    const double density = material.density[number];
    const double speed = mechanics::dilatational_speed(material.elasticity[number], density);
    const double length = std::cbrt(t.volume);
    Cell& cell = cells_.emplace_back(Cell{t.nodes, {}, t.volume * density * speed * length, length / speed});
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t i = 0; i < 3; ++i) cell.gradient[a][i] = static_cast<float>(t.gradient[a + 1][i]);
  }
}

void ViscousForce::add_largest(double factor, std::span<const double> velocity,
                               std::span<double> force) const {
  const double coefficient = factor * this->coefficient(greatest_strain);
  for (const Cell& cell : cells_) {
    double rate = 0;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t i = 0; i < 3; ++i)
        rate += static_cast<double>(cell.gradient[a][i]) *
                (velocity[index(cell.nodes[a + 1], i)] - velocity[index(cell.nodes[0], i)]);
    add_cell(
        cell, coefficient * cell.impedance * rate, [](double value) { return value; },
        [&](std::int32_t node, std::size_t i, double value) { force[index(node, i)] += value; });
  }
}

}  // namespace crackle::dynamics
