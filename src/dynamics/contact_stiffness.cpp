// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact_stiffness.h"

#include "common/index.h"
#include "common/median.h"
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

std::vector<double> tool_stiffness(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                   const mechanics::PdsOperators& operators, const ContactScale& scale) {
  const auto& mass = operators.node_mass;
  const std::vector<double> surface = surface_areas(subdomain);
  std::vector<double> ratios;
  for (std::size_t n = 0; n < mass.size(); ++n)
    if (surface[n] > 0) ratios.push_back(mass[n] / surface[n]);
  // Per depth, the same everywhere.
  const double pressure = tool_factor * scale.rate * median(parallel::gather_all<double>(group, ratios));
  std::vector<double> stiffness(mass.size());
  for (std::size_t n = 0; n < mass.size(); ++n) {
    // A node inside the body stands for the side of a cube of its volume.
    const bool is_inside = surface[n] == 0;
    const double area = is_inside ? std::pow(std::cbrt(operators.node_volume[n]), 2) : surface[n];
    stiffness[n] = std::min(pressure * area, (is_inside ? 1 : tool_factor) * scale.rate * mass[n]);
  }
  return stiffness;
}

std::vector<mechanics::NodeStiffness> largest_contact(const parallel::Communicator& group,
                                                      const input::Model& model,
                                                      const geometry::Subdomain& subdomain,
                                                      const mechanics::PdsOperators& operators,
                                                      const ContactScale& scale) {
  const std::vector<double> surface = surface_areas(subdomain);
  const std::vector<double> of_tools = model.tools.empty()
                                           ? std::vector<double>(surface.size())
                                           : tool_stiffness(group, subdomain, operators, scale);
  std::vector<mechanics::NodeStiffness> springs;
  for (std::size_t n = 0; n < surface.size(); ++n) {
    const double of_surfaces = model.surface_contact() ? scale.rate * operators.node_mass[n] : 0;
    const double stiffness = std::max(of_surfaces, surface[n] > 0 ? of_tools[n] : 0);
    if (stiffness > 0)
      springs.push_back({static_cast<std::int32_t>(n), {stiffness, stiffness, stiffness, 0, 0, 0}});
  }
  return springs;
}

}  // namespace crackle::dynamics
