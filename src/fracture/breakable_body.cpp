// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/breakable_body.h"

#include "crackle/fracture/principal_stress.h"

namespace crackle::fracture {

using mechanics::Symmetric;
using mechanics::Vector;

std::array<Vector, n_cuts> cut_areas(const mechanics::TetrahedronOperator& t) {
  std::array<Vector, n_cuts> areas{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t a = 0; a < 4; ++a) areas[a][i] = t.volume * t.gradient[a][i];
    for (std::size_t k = 1; k < 4; ++k) areas[3 + k][i] = t.volume * (t.gradient[0][i] + t.gradient[k][i]);
  }
  return areas;
}

int most_loaded_cut(const mechanics::TetrahedronOperator& tetrahedron, const Symmetric& sigma) {
  const auto areas = cut_areas(tetrahedron);
  int best = 0;
  double best_traction = 0;
  for (int cut = 0; cut < n_cuts; ++cut) {
    const Vector& area = areas[static_cast<std::size_t>(cut)];
    const double traction = mechanics::dot(area, mechanics::apply(sigma, area)) / mechanics::dot(area, area);
    if (cut == 0 || traction > best_traction) {
      best = cut;
      best_traction = traction;
    }
  }
  return best;
}

BreakableBody::BreakableBody(const geometry::Subdomain& subdomain, const input::Material& material)
    : subdomain_(&subdomain),
      operators_(mechanics::make_operators(subdomain, material.density)),
      edges_(mechanics::make_edges(subdomain)),
      elasticity_(material),
      force_(std::make_unique<mechanics::ReferenceForce>(operators_, elasticity_)),
      broken_(subdomain.tetrahedra.size(), 0) {}

void BreakableBody::release(std::int32_t tetrahedron, const Symmetric& strain, double load_time,
                            double phase_time) {
  const auto index = static_cast<std::size_t>(tetrahedron);
  const auto& t = operators_.tetrahedra[index];
  const Symmetric sigma = elasticity_(strain);
  restore(tetrahedron,
          {subdomain_->tetrahedron_number[index], load_time, phase_time, largest_principal(sigma),
           0.5 * t.volume * mechanics::contract(sigma, strain), most_loaded_cut(t, sigma)});
}

void BreakableBody::restore(std::int32_t tetrahedron, const Break& record) {
  const auto index = static_cast<std::size_t>(tetrahedron);
  force_->release(tetrahedron);
  broken_[index] = 1;
  order_.push_back(tetrahedron);
  if (subdomain_->counted[index] != 0) records_.push_back(record);
}

std::vector<double> BreakableBody::strain_energies(std::span<const double> displacement) const {
  std::vector<double> energies;
  energies.reserve(operators_.tetrahedra.size());
  for (std::size_t i = 0; i < operators_.tetrahedra.size(); ++i) {
    if (broken_[i] != 0 || subdomain_->counted[i] == 0) continue;
    const auto& t = operators_.tetrahedra[i];
    const Symmetric eps = mechanics::strain(t, displacement);
    energies.push_back(0.5 * t.volume * mechanics::contract(elasticity_(eps), eps));
  }
  return energies;
}

std::vector<double> BreakableBody::released_energies() const {
  std::vector<double> energies;
  energies.reserve(records_.size());
  for (const auto& record : records_) energies.push_back(record.released_energy);
  return energies;
}

}  // namespace crackle::fracture
