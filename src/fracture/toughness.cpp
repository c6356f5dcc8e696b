// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/toughness.h"

#include "common/index.h"
#include "common/real.h"
#include "fracture/material_field.h"
#include "geometry/mother_points.h"
#include "input/softening_limits.h"
#include "parallel/agreement.h"
#include "parallel/ghost_exchange.h"

#include <algorithm>
#include <cmath>

namespace crackle::fracture {

namespace {

/// toughness_factor() over Young's modulus.
double energy_factor(input::Release release, double poisson_ratio, double youngs_modulus) {
  return toughness_factor(release, poisson_ratio) / youngs_modulus;
}

double energy_factor(const input::MaterialModel& model) {
  const input::Material& material = model.material();
  return energy_factor(model.fracture.release, material.poisson_ratio, material.youngs_modulus);
}

/// The input's strength and toughness in each tetrahedron of a body: those of its material, or of the
/// interface that it touches.
class LocalFracture {
public:
  LocalFracture(const input::MaterialModel& model, const BreakableBody& body)
      : model_(model), body_(body), span_(span_of(body.subdomain())) {
    for (std::size_t m = 0; m < model.materials.size(); ++m) of_material_.push_back(model.fracture_of(m));
  }

  double strength(std::size_t t) const {
    const input::Interface* const interface = interface_at(t);
    return interface != nullptr && interface->strength > 0 ? interface->strength : own(t).strength;
  }
  double toughness(std::size_t t) const {
    const input::Interface* const interface = interface_at(t);
    return interface != nullptr && interface->toughness > 0 ? interface->toughness : own(t).toughness;
  }
  double energy_factor(std::size_t t) const {
    const input::Material& material = model_.materials[span_.material_of(t)];
    // Without variation the modulus is the input's to the last bit.
    const double modulus =
        material.variation || model_.maps_stiffness
            ? 2 * body_.elasticity()[static_cast<std::int32_t>(t)].mu * (1 + material.poisson_ratio)
            : material.youngs_modulus;
    return fracture::energy_factor(model_.fracture.release, material.poisson_ratio, modulus);
  }
  /// By the input's raster.
  double strength_factor(std::size_t t) const {
    return model_.maps_strength ? static_cast<double>(body_.subdomain().map_factor[t]) : 1;
  }
  double poisson_ratio(std::size_t t) const { return model_.materials[span_.material_of(t)].poisson_ratio; }

private:
  const input::Fracture& own(std::size_t t) const { return of_material_[span_.material_of(t)]; }
  const input::Interface* interface_at(std::size_t t) const {
    const auto& interface = body_.subdomain().interface;
    return interface.empty() || interface[t] == 0 ? nullptr : &model_.interfaces[interface[t] - 1u];
  }

  const input::MaterialModel& model_;
  const BreakableBody& body_;
  TetrahedronSpan span_;
  std::vector<input::Fracture> of_material_;
};

}  // namespace

double spacings_per_length(input::Release release, double poisson_ratio) {
  return input::fitted_to_poisson_ratio(3.05, 0.34, poisson_ratio) / toughness_factor(release, poisson_ratio);
}

double toughness_of(const input::MaterialModel& model, double strength, double spacing) {
  return energy_factor(model) * strength * strength * spacing;
}

double strength_of(const input::MaterialModel& model, double toughness, double spacing) {
  return std::sqrt(toughness / (energy_factor(model) * spacing));
}

std::optional<Range> spacing_along_ligaments(const input::Mesh& mesh, const geometry::Body& body) {
  if (std::ranges::none_of(body.crack_starts(), &geometry::CrackStart::is_straight)) return std::nullopt;
  const geometry::SpacingField spacing(body, mesh);
  constexpr int n_steps = 200;  // from the tip to the end
  Range range{infinity, 0};
  for (const geometry::CrackStart& start : body.crack_starts()) {
    if (!start.is_straight) continue;
    for (int layer = 0; layer <= 2; ++layer) {
      for (int step = 0; step <= n_steps; ++step) {
        geometry::Point p{layer * body.size()[0] / 2, 0, 0};
        for (std::size_t i = 1; i < 3; ++i)
          p[i] = start.tip[i] + step * (start.end[i] - start.tip[i]) / n_steps;
        if (!body.contains(p)) break;
        const double local = spacing(p);
        range = {std::min(range.least, local), std::max(range.greatest, local)};
      }
    }
  }
  return range;
}

namespace {

/// Edge length of the regular tetrahedron with the mean volume of those around each node [m].
std::vector<double> node_spacings(const mechanics::TetrahedronOperators& tetrahedra, std::size_t n_nodes) {
  std::vector<double> volume(n_nodes), n_around(n_nodes);
  for (const auto& t : tetrahedra) {
    for (const auto node : t.nodes) {
      volume[index(node)] += t.volume;
      ++n_around[index(node)];
    }
  }
  for (std::size_t i = 0; i < volume.size(); ++i)
    volume[i] = std::cbrt(6 * std::sqrt(2.0) * (volume[i] / n_around[i]));
  return volume;
}

std::vector<double> means_over_corners(const mechanics::TetrahedronOperators& tetrahedra,
                                       std::span<const double> at_node) {
  std::vector<double> means;
  means.reserve(tetrahedra.size());
  for (const auto& t : tetrahedra) {
    double sum = 0;
    for (const auto node : t.nodes) sum += at_node[index(node)];
    means.push_back(sum / 4);
  }
  return means;
}

}  // namespace

std::vector<double> local_spacings(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                   const mechanics::PdsOperators& operators) {
  auto at_node = node_spacings(operators.tetrahedra, subdomain.nodes.size());
  // A rank has all tetrahedra around the nodes that it owns.
  parallel::GhostExchange<double> exchange(group, subdomain.layout);
  parallel::check_peers(group);
  exchange.update(at_node);
  return means_over_corners(operators.tetrahedra, at_node);
}

std::vector<double> local_spacings(const TetrahedronSpan& whole) {
  const mechanics::TetrahedronOperators tetrahedra(whole.tetrahedra, whole.nodes);
  return means_over_corners(tetrahedra, node_spacings(tetrahedra, whole.nodes.size()));
}

std::vector<double> fracture_spacings(const parallel::Communicator& group, const input::MaterialModel& model,
                                      const BreakableBody& body) {
  const double length = model.fracture.length;
  if (length == 0) return local_spacings(group, body.subdomain(), body.operators());
  const LocalFracture local(model, body);
  std::vector<double> spacings(body.operators().tetrahedra.size());
  for (std::size_t t = 0; t < spacings.size(); ++t)
    spacings[t] = spacings_per_length(model.fracture.release, local.poisson_ratio(t)) * length;
  return spacings;
}

namespace {

std::vector<double> growth_strengths(const parallel::Communicator& group, const input::MaterialModel& model,
                                     std::uint64_t sample, const BreakableBody& body) {
  if (!model.fracture_of(0).separates_nucleation()) return {};
  auto strengths = fracture_spacings(group, model, body);
  parallel::agree(group, [&] {
    const LocalFracture local(model, body);
    const auto factors = toughness_factors(model, sample, span_of(body.subdomain()));
    for (std::size_t t = 0; t < strengths.size(); ++t)
      strengths[t] = local.strength_factor(t) *
                     std::sqrt(factors[t] * local.toughness(t) / (local.energy_factor(t) * strengths[t]));
  });
  return strengths;
}

}  // namespace

Strengths tetrahedron_strengths(const parallel::Communicator& group, const input::MaterialModel& model,
                                std::uint64_t sample, const BreakableBody& body) {
  const LocalFracture local(model, body);
  std::vector<double> strengths(body.operators().tetrahedra.size());
  for (std::size_t t = 0; t < strengths.size(); ++t) strengths[t] = local.strength(t);
  if (model.fracture_of(0).strength == 0) {
    strengths = fracture_spacings(group, model, body);
    for (std::size_t t = 0; t < strengths.size(); ++t)
      strengths[t] = std::sqrt(local.toughness(t) / (local.energy_factor(t) * strengths[t]));
  }
  if (model.fracture.variation)
    parallel::agree(group, [&] {
      const auto factors = strength_factors(model, sample, span_of(body.subdomain()));
      for (std::size_t t = 0; t < strengths.size(); ++t) strengths[t] *= factors[t];
    });
  for (std::size_t t = 0; t < strengths.size(); ++t) strengths[t] *= local.strength_factor(t);
  auto growth = growth_strengths(group, model, sample, body);
  if (!model.fracture_of(0).nucleates_by_means())
    for (std::size_t t = 0; t < growth.size(); ++t) strengths[t] = std::max(strengths[t], growth[t]);
  return {std::move(strengths), std::move(growth)};
}

std::vector<double> tetrahedron_toughness(const parallel::Communicator& group,
                                          const input::MaterialModel& model, const BreakableBody& body,
                                          std::span<const double> strengths) {
  const LocalFracture local(model, body);
  auto toughness = fracture_spacings(group, model, body);
  for (std::size_t t = 0; t < toughness.size(); ++t)
    toughness[t] = local.energy_factor(t) * strengths[t] * strengths[t] * toughness[t];
  return toughness;
}

std::vector<double> dissipations(const parallel::Communicator& group, const input::MaterialModel& model,
                                 std::uint64_t sample, const BreakableBody& body) {
  if (!model.fracture.softens()) return {};
  auto dissipations = local_spacings(group, body.subdomain(), body.operators());
  parallel::agree(group, [&] {
    const LocalFracture local(model, body);
    const auto factors = toughness_factors(model, sample, span_of(body.subdomain()));
    for (std::size_t t = 0; t < dissipations.size(); ++t)
      dissipations[t] = factors[t] * local.toughness(t) / (input::spacings_per_band * dissipations[t]);
  });
  return dissipations;
}

}  // namespace crackle::fracture
