// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/residual_stiffness.h"

#include "geometry/dual_facets.h"

#include <algorithm>
#include <utility>

namespace crackle::mechanics {

namespace {

constexpr bool contains(EdgeSet set, std::size_t edge) {
  return ((set >> edge) & 1) != 0;
}

/// Corner positions relative to corner 0: the inverse of the gradient matrix.
std::array<Vector, 4> corners(const TetrahedronOperator& t) {
  const auto& g = t.gradient;
  const double determinant = dot(g[1], cross(g[2], g[3]));
  std::array<Vector, 4> x{};
  for (std::size_t a = 1; a < 4; ++a) x[a] = cross(g[a % 3 + 1], g[(a + 1) % 3 + 1]) / determinant;
  return x;
}

/// The strain that stretches only this edge, with d . eps . d = 1.
Symmetric stretch_of(const TetrahedronOperator& t, std::size_t edge) {
  const auto [i, j] = geometry::dual_facet_nodes[edge];
  Symmetric stretch = symmetric_product(t.gradient[i], t.gradient[j]);
  for (double& component : stretch) component = -component;
  return stretch;
}

/// A cut that slips in equilibrium resists with at least this share of its shear modulus.
constexpr double stabilizing_share = 1e-4;

}  // namespace

Symmetric CutContact::strain(const std::array<Vector, 4>& displacement) const {
  std::array<double, 12> u{};
  for (std::size_t a = 1; a < 4; ++a)
    for (std::size_t k = 0; k < 3; ++k) u[3 * a + k] = displacement[a][k] - displacement[0][k];
  return mechanics::strain(intact, u);
}

EdgeStiffness edge_stiffness(const TetrahedronOperator& t, const IsotropicElasticity& elasticity,
                             EdgeSet released) {
  EdgeStiffness result{};
  const auto x = corners(t);
  std::array<Symmetric, 6> stretch{};
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [i, j] = geometry::dual_facet_nodes[k];
    result.edge[k] = x[j] - x[i];
    stretch[k] = stretch_of(t, k);
  }
  auto& k = result.k;
  for (std::size_t p = 0; p < 6; ++p) {
    const Symmetric sigma = elasticity(stretch[p]);
    for (std::size_t q = 0; q <= p; ++q) k[p][q] = k[q][p] = contract(sigma, stretch[q]);
  }
  // One released edge after the other takes the strain at which its force vanishes.
  for (std::size_t r = 0; r < 6; ++r) {
    if (!contains(released, r)) continue;
    const auto row = k[r];
    for (std::size_t p = 0; p < 6; ++p)
      for (std::size_t q = 0; q <= p; ++q) k[p][q] = k[q][p] = k[p][q] - row[p] * row[q] / row[r];
    for (std::size_t p = 0; p < 6; ++p) k[r][p] = k[p][r] = 0;
  }
  return result;
}

Symmetric EdgeStiffness::stress(const Symmetric& strain) const {
  std::array<double, 6> e{};
  for (std::size_t p = 0; p < 6; ++p) e[p] = dot(edge[p], apply(strain, edge[p]));
  Symmetric sigma{};
  for (std::size_t p = 0; p < 6; ++p) {
    double q = 0;
    for (std::size_t r = 0; r < 6; ++r) q += k[p][r] * e[r];
    const Vector& d = edge[p];
    sigma[0] += q * d[0] * d[0];
    sigma[1] += q * d[1] * d[1];
    sigma[2] += q * d[2] * d[2];
    sigma[3] += q * d[1] * d[2];
    sigma[4] += q * d[0] * d[2];
    sigma[5] += q * d[0] * d[1];
  }
  return sigma;
}

Matrix EdgeStiffness::coupling(std::size_t a, std::size_t b) const {
  // The gradient of a corner along an edge is 1 at the edge's end and -1 at its start.
  const auto sign = [](std::size_t p, std::size_t corner) {
    const auto [i, j] = geometry::dual_facet_nodes[p];
    return corner == j ? 1.0 : corner == i ? -1.0 : 0.0;
  };
  Matrix block{};
  for (std::size_t p = 0; p < 6; ++p) {
    for (std::size_t q = 0; q < 6; ++q) {
      const double factor = sign(p, a) * sign(q, b) * k[p][q];
      if (factor == 0) continue;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) block[i][j] += factor * edge[p][i] * edge[q][j];
    }
  }
  return block;
}

ResidualStiffness::ResidualStiffness(const PdsOperators& operators, const ElasticityField& elasticity)
    : operators_(&operators),
      elasticity_(&elasticity),
      released_(operators.tetrahedra.size(), no_edge),
      place_(operators.tetrahedra.size(), -1) {}

Symmetric ResidualStiffness::own_stress(std::int32_t tetrahedron, const Symmetric& strain) const {
  if (is_intact(tetrahedron)) return (*elasticity_)[tetrahedron](strain);
  return carries(tetrahedron) ? partial(tetrahedron).stress(strain) : Symmetric{};
}

Symmetric ResidualStiffness::stress(std::int32_t tetrahedron, const Symmetric& strain) const {
  if (is_intact(tetrahedron)) return (*elasticity_)[tetrahedron](strain);
  Symmetric sigma = own_stress(tetrahedron, strain);
  if (has_contact(tetrahedron)) {
    const auto contact = contact_stress(index(contact_number(tetrahedron)), strain);
    for (std::size_t i = 0; i < sigma.size(); ++i) sigma[i] += contact[i];
  }
  return sigma;
}

void ResidualStiffness::add_contact(std::int32_t tetrahedron, const Vector& normal) {
  if (contact_place_.empty()) contact_place_.assign(released_.size(), -1);
  contact_place_[index(tetrahedron)] = static_cast<std::int32_t>(contacts_.size());
  acting_.push_back(static_cast<std::int32_t>(contacts_.size()));
  ++acting_version_;
  contacts_.push_back(tetrahedron);
  const auto reduction = reductions_.find(tetrahedron);
  CutContact& cut = cuts_.emplace_back();
  cut.normal = normal;
  cut.intact = operators_->tetrahedra[index(tetrahedron)];
  cut.corners = std::exchange(cut.intact.nodes, {0, 1, 2, 3});
  for (std::size_t a = 0; a < 4; ++a) cut.closer[a] = dot(normal, cut.intact.gradient[a]);
  if (reduction != reductions_.end()) cut.share = 1 - reduction->second.share;
}

void ResidualStiffness::find_acting() {
  acting_.clear();
  ++acting_version_;
  for (std::size_t i = 0; i < cuts_.size(); ++i)
    if (cuts_[i].acts()) acting_.push_back(static_cast<std::int32_t>(i));
}

ResidualStiffness::CutState ResidualStiffness::cut_state(std::size_t i, const Symmetric& strain) const {
  const CutContact& cut = cuts_[i];
  const Vector stretch = mechanics::apply(strain, cut.normal);
  const double along = dot(cut.normal, stretch);
  CutState state{along - cut.closed_at, {}, {}, false};
  if (friction_ == 0 || (state.closing >= 0 && cut.is_open)) return state;
  state.shear = 2 * (stretch - along * cut.normal);
  const IsotropicElasticity& material = (*elasticity_)[contacts_[i]];
  if (cut.is_open) return state;
  state.traction = material.mu * (state.shear - cut.slip);
  const double most = friction_ * material.youngs_modulus() * std::max(-state.closing, 0.0);
  const double size = norm(state.traction);
  state.slips = size > most;
  if (state.slips) state.traction = most / size * state.traction;
  return state;
}

Symmetric ResidualStiffness::contact_stress(std::size_t i, const Symmetric& strain) const {
  const CutContact& cut = cuts_[i];
  if (!contacts_act_ || !cut.acts()) return {};
  const CutState state = cut_state(i, strain);
  if (state.closing >= 0) return {};
  const Vector& n = cut.normal;
  const double pressure = cut.share * ((*elasticity_)[contacts_[i]].youngs_modulus() * state.closing);
  Symmetric sigma{pressure * n[0] * n[0], pressure * n[1] * n[1], pressure * n[2] * n[2],
                  pressure * n[1] * n[2], pressure * n[0] * n[2], pressure * n[0] * n[1]};
  if (friction_ == 0) return sigma;
  const Symmetric shear = symmetric_product(cut.share * state.traction, n);
  for (std::size_t k = 0; k < sigma.size(); ++k) sigma[k] += 2 * shear[k];
  return sigma;
}

void ResidualStiffness::start_contact(std::size_t i, const Symmetric& strain) {
  CutContact& cut = cuts_[i];
  const Vector stretch = mechanics::apply(strain, cut.normal);
  const double along = dot(cut.normal, stretch);
  cut.closed_at = std::min(along, 0.0);
  cut.slip = 2 * (stretch - along * cut.normal);
  cut.friction = cut.dissipated = 0;
  cut.is_open = cut.is_apart = cut.rests = false;
  cut.opening_before = 0;
}

void ResidualStiffness::settle_contact(std::size_t i, const Symmetric& strain) {
  CutContact& cut = cuts_[i];
  if (cut.is_apart) return;
  const CutState state = cut_state(i, strain);
  if (state.closing >= 0) cut.closed_at = std::min(cut.closed_at + state.closing, 0.0);
  const bool was_open = std::exchange(cut.is_open, cut.closed_at == 0 && state.closing > 0);
  if (friction_ == 0) return;
  if (was_open) {
    cut.slip = state.shear;
    return;
  }
  const double carried = cut.share * norm(state.traction);
  if (state.slips) {
    const Vector slip = state.shear - state.traction / (*elasticity_)[contacts_[i]].mu;
    cut.dissipated += cut.intact.volume * 0.5 * (cut.friction + carried) * norm(slip - cut.slip);
    cut.slip = slip;
  }
  cut.friction = carried;
}

void ResidualStiffness::settle_new_contact(std::int32_t tetrahedron, const Symmetric& strain) {
  if (friction_ == 0 || !has_contact(tetrahedron)) return;
  const auto i = index(contact_number(tetrahedron));
  settle_contact(i, strain);
  cuts_[i].dissipated = 0;
}

CutTangent ResidualStiffness::cut_tangent(std::size_t i, const Symmetric& strain) const {
  const CutContact& cut = cuts_[i];
  CutTangent tangent;
  if (!contacts_act_ || !cut.acts()) return tangent;
  const CutState state = cut_state(i, strain);
  tangent.is_closed = state.closing < 0 || (state.closing == 0 && !cut.is_open);
  if (friction_ == 0 || !tangent.is_closed) return tangent;
  tangent.along = tangent.on_its_way = cut.is_open ? stabilizing_share : 1;
  if (!state.slips) return tangent;
  const Vector way = state.shear - cut.slip;
  const double length = norm(way);
  tangent.way = way / length;
  tangent.along =
      std::max(stabilizing_share, norm(state.traction) / ((*elasticity_)[contacts_[i]].mu * length));
  tangent.on_its_way = stabilizing_share;
  return tangent;
}

void ResidualStiffness::linearize(std::int32_t tetrahedron, const ResidualStiffness& at,
                                  const CutTangent& tangent) {
  const auto t = index(tetrahedron);
  released_[t] = at.released_[t];
  if (!at.is_intact(tetrahedron) && at.carries(tetrahedron))
    make_partial(tetrahedron) = at.partial(tetrahedron);
  if (!tangent.is_closed) return;
  if (!at.carries(tetrahedron)) {
    make_partial(tetrahedron) = stiffness_without(tetrahedron, all_edges);
    released_[t] = softened;
  }
  const CutContact& cut = at.cuts_[index(at.contact_number(tetrahedron))];
  const IsotropicElasticity& material = (*elasticity_)[tetrahedron];
  std::array<double, 6> closing{}, sliding{};
  std::array<Vector, 6> shear{};
  for (std::size_t p = 0; p < 6; ++p) {
    const Vector stretch = mechanics::apply(stretch_of(cut.intact, p), cut.normal);
    closing[p] = dot(cut.normal, stretch);
    shear[p] = 2 * (stretch - closing[p] * cut.normal);
    sliding[p] = dot(shear[p], tangent.way);
  }
  auto& k = make_partial(tetrahedron).k;
  for (std::size_t p = 0; p < 6; ++p)
    for (std::size_t q = 0; q < 6; ++q)
      k[p][q] +=
          cut.share * (material.youngs_modulus() * closing[p] * closing[q] +
                       material.mu * (tangent.along * dot(shear[p], shear[q]) +
                                      (tangent.on_its_way - tangent.along) * (sliding[p] * sliding[q])));
}

double ResidualStiffness::contact_energy(std::size_t i, const Symmetric& strain) const {
  const CutContact& cut = cuts_[i];
  if (!contacts_act_ || !cut.acts()) return 0;
  const CutState state = cut_state(i, strain);
  if (state.closing >= 0) return 0;
  const IsotropicElasticity& material = (*elasticity_)[contacts_[i]];
  return 0.5 * cut.intact.volume * cut.share *
         (material.youngs_modulus() * state.closing * state.closing +
          dot(state.traction, state.traction) / material.mu);
}

double ResidualStiffness::energy(std::int32_t tetrahedron, const Symmetric& strain) const {
  const auto energy_of = [&](const Symmetric& sigma) {
    return 0.5 * operators_->tetrahedra[index(tetrahedron)].volume * contract(sigma, strain);
  };
  if (!has_contact(tetrahedron)) return energy_of(stress(tetrahedron, strain));
  return (carries(tetrahedron) ? energy_of(partial(tetrahedron).stress(strain)) : 0) +
         contact_energy(index(contact_number(tetrahedron)), strain);
}

void ResidualStiffness::release(std::int32_t tetrahedron, EdgeSet edges) {
  const auto i = index(tetrahedron);
  if (const auto reduction = reductions_.find(tetrahedron); reduction != reductions_.end()) {
    reduction->second.edges = static_cast<EdgeSet>(reduction->second.edges | edges);
    return interpolate(tetrahedron, reduction->second);
  }
  const auto now = static_cast<EdgeSet>(released(tetrahedron) | edges);
  // Create it before recording the release, as allocation may fail.
  if (now != no_edge && now != all_edges) make_partial(tetrahedron) = stiffness_without(tetrahedron, now);
  released_[i] = now;
}

void ResidualStiffness::begin_release(std::int32_t tetrahedron, EdgeSet edges) {
  const EdgeStiffness before =
      is_intact(tetrahedron) ? stiffness_without(tetrahedron, no_edge) : partial(tetrahedron);
  make_partial(tetrahedron) = before;
  reductions_[tetrahedron] = {before, edges, 1};
  released_[index(tetrahedron)] = softened;
}

void ResidualStiffness::reduce(std::int32_t tetrahedron, double share) {
  auto& reduction = reductions_.at(tetrahedron);
  reduction.share = share;
  if (has_contact(tetrahedron)) cuts_[index(contact_number(tetrahedron))].share = 1 - share;
  if (share > 0) return interpolate(tetrahedron, reduction);
  const EdgeSet edges = reduction.edges;
  reductions_.erase(tetrahedron);
  released_[index(tetrahedron)] = no_edge;
  release(tetrahedron, edges);
}

void ResidualStiffness::interpolate(std::int32_t tetrahedron, const Reduction& reduction) {
  const auto after = stiffness_without(tetrahedron, reduction.edges).k;
  auto& k = make_partial(tetrahedron).k;
  for (std::size_t p = 0; p < 6; ++p)
    for (std::size_t q = 0; q < 6; ++q)
      k[p][q] = after[p][q] + reduction.share * (reduction.before.k[p][q] - after[p][q]);
}

void ResidualStiffness::soften(std::int32_t tetrahedron, double share) {
  auto& stiffness = make_partial(tetrahedron);
  stiffness = stiffness_without(tetrahedron, no_edge);
  for (auto& row : stiffness.k)
    for (double& entry : row) entry *= share;
  released_[index(tetrahedron)] = softened;
}

EdgeStiffness ResidualStiffness::stiffness_without(std::int32_t tetrahedron, EdgeSet released) const {
  return edge_stiffness(operators_->tetrahedra[index(tetrahedron)], (*elasticity_)[tetrahedron], released);
}

EdgeStiffness& ResidualStiffness::make_partial(std::int32_t tetrahedron) {
  auto& place = place_[index(tetrahedron)];
  if (place < 0) {
    partial_.emplace_back();
    place = static_cast<std::int32_t>(partial_.size()) - 1;
  }
  return partial_[index(place)];
}

}  // namespace crackle::mechanics
