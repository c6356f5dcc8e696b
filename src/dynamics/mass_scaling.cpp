// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/mass_scaling.h"

#include "common/index.h"
#include "dynamics/stable_step.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace crackle::dynamics {

namespace {

constexpr int n_halvings = 60;
constexpr double corridor_volume = 1.5 * 1.5 * 1.5;  // of tetrahedra, relative to the finest
constexpr std::int64_t nodes_per_finest = 100;

/// The least number up to `most` from which on a condition holds, to a part in 2^60 of `most`.
template <class Holds>
double least_for_which(double most, const Holds& holds) {
  double low = 0;
  for (int i = 0; i < n_halvings; ++i) {
    const double middle = 0.5 * (low + most);
    (holds(middle) ? most : low) = middle;
  }
  return most;
}

double largest_of(const parallel::Communicator& group, const std::vector<double>& values) {
  parallel::check_peers(group);
  return parallel::largest_of_all(group, values.empty() ? 0 : std::ranges::max(values));
}

/// 1 at each owned node of the corridor. Collective.
std::vector<std::uint8_t> find_corridor(const parallel::Communicator& group,
                                        const geometry::Subdomain& subdomain,
                                        const mechanics::PdsOperators& operators) {
  std::vector<double> volume =
      operators.node_volume;  // a quarter of the mean of the tetrahedra around the node
  std::vector<std::int32_t> n_around(volume.size(), 0);
  for (const auto& nodes : subdomain.tetrahedra)
    for (const auto node : nodes)
      if (node < subdomain.layout.n_owned) ++n_around[index(node)];
  for (std::size_t n = 0; n < volume.size(); ++n) volume[n] /= n_around[n];
  std::vector<std::uint8_t> is_in(volume.size());
  const double finest = least_for_which(largest_of(group, volume), [&](double bound) {
    const auto n_below = std::ranges::count_if(volume, [&](double v) { return v <= bound; });
    return parallel::all_reduce<std::int64_t>(group, n_below, MPI_SUM) * nodes_per_finest >=
           subdomain.layout.n_global;
  });
  std::ranges::transform(volume, is_in.begin(),
                         [&](double v) { return v <= corridor_volume * finest ? 1 : 0; });
  return is_in;
}

/// Sums over the owned nodes of the body, and over those of the corridor. Collective.
template <class Term>
std::array<double, 2> sums(const parallel::Communicator& group, const std::vector<std::uint8_t>& corridor,
                           const Term& term) {
  std::vector<std::vector<double>> terms(2);
  for (std::size_t n = 0; n < corridor.size(); ++n) {
    const double value = term(n);
    if (value == 0) continue;
    terms[0].push_back(value);
    if (corridor[n] != 0) terms[1].push_back(value);
  }
  const auto found = parallel::exact_sums(group, terms);
  return {found[0], found[1]};
}

}  // namespace

std::vector<double> frequency_bounds(const geometry::Subdomain& subdomain,
                                     const mechanics::PdsOperators& operators,
                                     const mechanics::ElasticityField& elasticity) {
  std::vector<mechanics::Symmetric> own(index(subdomain.layout.n_owned), mechanics::Symmetric{});
  std::vector<double> bounds(own.size(), 0.0);
  for (std::int32_t number = 0; number < subdomain.n_tetrahedra(); ++number) {
    const mechanics::TetrahedronOperator t = operators.tetrahedra[index(number)];
    const auto& [lambda, mu] = elasticity[number];
    for (std::size_t i = 0; i < 4; ++i) {
      if (t.nodes[i] >= subdomain.layout.n_owned) continue;
      const Vector& a = t.gradient[i];
      const mechanics::Symmetric product = mechanics::symmetric_product(a, a);
      for (std::size_t k = 0; k < 6; ++k)
        own[index(t.nodes[i])][k] += t.volume * ((lambda + mu) * product[k] + (k < 3 ? mu * dot(a, a) : 0));
      // Frobenius' norm of V (lambda a b^T + mu b a^T + mu (a . b) I).
      for (std::size_t j = 0; j < 4; ++j) {
        const Vector& b = t.gradient[j];
        if (i != j)
          bounds[index(t.nodes[i])] +=
              t.volume * std::sqrt((lambda * lambda + mu * mu) * (dot(a, a) * dot(b, b)) +
                                   mu * (4 * lambda + 5 * mu) * (dot(a, b) * dot(a, b)));
      }
    }
  }
  for (std::size_t n = 0; n < own.size(); ++n) {
    const mechanics::Symmetric& k = own[n];
    Eigen::Matrix3d block;
    block << k[0], k[5], k[4], k[5], k[1], k[3], k[4], k[3], k[2];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(block, Eigen::EigenvaluesOnly);
    bounds[n] = (bounds[n] + solver.eigenvalues()[2]) / operators.node_mass[n];
  }
  return bounds;
}

std::optional<MassScaling> scale_masses(const parallel::Communicator& group, const input::Model& model,
                                        const geometry::Subdomain& subdomain,
                                        mechanics::PdsOperators& operators,
                                        const mechanics::MaterialField& material,
                                        const mechanics::InternalForce& force) {
  const double most = model.time.mass_scaling;
  if (most == 0) return {};
  const auto step = [&] {
    return stable_step(group, model.time.integrator, model.bulk_viscosity(), subdomain, operators, material,
                       force);
  };
  const double step_before = step();
  auto& mass = operators.node_mass;
  const std::vector<double> bounds = frequency_bounds(subdomain, operators, material.elasticity);
  const std::vector<std::uint8_t> corridor = find_corridor(group, subdomain, operators);
  const auto whole = sums(group, corridor, [&](std::size_t n) { return mass[n]; });
  const auto more = [&](std::size_t n, double limit) {
    return bounds[n] > limit ? mass[n] * (bounds[n] / limit - 1) : 0;
  };
  const auto added = [&](double limit) {
    return sums(group, corridor, [&](std::size_t n) { return more(n, limit); });
  };
  const double limit = least_for_which(largest_of(group, bounds), [&](double candidate) {
    const auto sum = added(candidate);
    return sum[0] <= most * whole[0] && sum[1] <= most * whole[1];
  });
  const auto sum = added(limit);
  const auto n_scaled = std::ranges::count_if(bounds, [&](double bound) { return bound > limit; });
  parallel::check_peers(group);
  const auto n_all = parallel::all_reduce<std::int64_t>(group, n_scaled, MPI_SUM);
  for (std::size_t n = 0; n < mass.size(); ++n) mass[n] += more(n, limit);
  return MassScaling{sum[0] / whole[0], sum[1] / whole[1],
                     static_cast<double>(n_all) / static_cast<double>(subdomain.layout.n_global),
                     step() / step_before};
}

std::string to_string(const MassScaling& scaling) {
  return fmt::format(
      "{:.2g} % of the mass, {:.2g} % in the corridor, at {:.2g} % of the nodes: a step {:.3g} "
      "times as long",
      100 * scaling.share, 100 * scaling.corridor_share, 100 * scaling.node_share, scaling.gain);
}

}  // namespace crackle::dynamics
