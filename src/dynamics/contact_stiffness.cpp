// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact_stiffness.h"

#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "dynamics/stable_step.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <cmath>

namespace crackle::dynamics {

std::vector<double> surface_areas(const geometry::Subdomain& subdomain) {
  std::vector<double> areas(index(subdomain.layout.n_owned), 0.0);
  for (const auto& triangle : subdomain.boundary) {
    const auto& x = subdomain.nodes;
    const auto& [a, b, c] = triangle.nodes;
    const double area = norm(cross(x[index(b)] - x[index(a)], x[index(c)] - x[index(a)])) / 2;
    for (const auto node : triangle.nodes)
      if (node < subdomain.layout.n_owned) areas[index(node)] += area / 3;
  }
  return areas;
}

ContactScale contact_scale(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const mechanics::PdsOperators& operators, const mechanics::InternalForce& force,
                           const input::SurfaceContact& contact) {
  const double omega_max = largest_frequency(group, subdomain, operators, force);
  return {contact.friction, contact.stiffness * omega_max * omega_max,
          std::cbrt(parallel::exact_sum(group, operators.node_volume) /
                    static_cast<double>(subdomain.layout.n_global))};
}

std::vector<mechanics::NodeStiffness> largest_contact(const ContactScale& scale,
                                                      const mechanics::PdsOperators& operators) {
  std::vector<mechanics::NodeStiffness> springs;
  for (std::size_t n = 0; n < operators.node_mass.size(); ++n) {
    const double stiffness = scale.rate * operators.node_mass[n];
    springs.push_back({static_cast<std::int32_t>(n), {stiffness, stiffness, stiffness, 0, 0, 0}});
  }
  return springs;
}

}  // namespace crackle::dynamics
