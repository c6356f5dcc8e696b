// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/breakable_body.h"

#include "fracture/equivalent_stress.h"
#include "geometry/dual_facets.h"
#include "geometry/face_neighbours.h"
#include "geometry/pre_crack.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <exception>
#include <stdexcept>

namespace crackle::fracture {

using mechanics::Symmetric;

std::array<Vector, n_cuts> cut_areas(const mechanics::TetrahedronOperator& t) {
  std::array<Vector, n_cuts> areas{};
  for (std::size_t a = 0; a < 4; ++a) areas[a] = t.volume * t.gradient[a];
  for (std::size_t k = 1; k < 4; ++k) areas[3 + k] = t.volume * (t.gradient[0] + t.gradient[k]);
  return areas;
}

int most_loaded_cut(const mechanics::TetrahedronOperator& tetrahedron, const Symmetric& sigma) {
  const auto areas = cut_areas(tetrahedron);
  int best = 0;
  double best_traction = 0;
  for (int cut = 0; cut < n_cuts; ++cut) {
    const Vector& area = areas[static_cast<std::size_t>(cut)];
    const double traction = dot(area, mechanics::apply(sigma, area)) / dot(area, area);
    if (cut == 0 || traction > best_traction) {
      best = cut;
      best_traction = traction;
    }
  }
  return best;
}

BreakableBody::BreakableBody(const geometry::Subdomain& subdomain, mechanics::MaterialField material,
                             std::unique_ptr<Release> release, input::Contact contact, double friction)
    : subdomain_(&subdomain),
      release_(release ? std::move(release) : make_release({})),
      contact_(contact),
      material_(std::move(material)),
      operators_(mechanics::make_operators(subdomain, material_.density)),
      edges_(mechanics::make_edges(subdomain)),
      residual_stiffness_(operators_, material_.elasticity),
      force_(operators_, residual_stiffness_, &initial_strain_),
      broken_(subdomain.tetrahedra.size(), 0) {
  residual_stiffness_.set_friction(friction);
}

void BreakableBody::set_release(std::unique_ptr<Release> release) {
  release_ = std::move(release);
  for (std::size_t t = 0; t < subdomain_->pre_crack.size(); ++t)
    if (const std::int32_t code = subdomain_->pre_crack[t]; code > 0)
      open(static_cast<std::int32_t>(t), geometry::PreCrackCut::from(code).cut, 0);
  n_checked_ = order_.size();
}

void BreakableBody::release(std::int32_t tetrahedron, const Symmetric& strain, double load_time,
                            double phase_time, bool moves) {
  const auto index = static_cast<std::size_t>(tetrahedron);
  if (broken_[index] != 0) throw std::logic_error("a tetrahedron was broken twice");
  const double energy = 0.5 * mechanics::contract(intact_stress(tetrahedron, strain), strain);
  if (const auto kept = release_->reduce(tetrahedron, energy))
    return reduce(tetrahedron, kept->share, strain, load_time, phase_time, kept->ductility);
  const Symmetric sigma = residual_stiffness_.stress(tetrahedron, strain);
  const double before = residual_stiffness_.energy(tetrahedron, strain);
  const int cut = most_loaded_cut(operators_.tetrahedra[index], intact_stress(tetrahedron, strain));
  const double remaining = moves ? release_->remaining(tetrahedron, 0) : 0;
  open(tetrahedron, cut, remaining);
  residual_stiffness_.settle_new_contact(tetrahedron, strain);
  const bool is_counted = subdomain_->owned[index] != 0;
  if (remaining > 0)
    releasing_.push_back(
        {tetrahedron, phase_time, is_counted ? std::optional(records_.size()) : std::nullopt});
  if (!is_counted) return;
  records_.push_back({subdomain_->tetrahedron_number[index], load_time, phase_time, largest_principal(sigma),
                      before - residual_stiffness_.energy(tetrahedron, strain), cut});
}

void BreakableBody::continue_releases(double phase_time,
                                      const std::function<Symmetric(std::int32_t)>& strain) {
  std::erase_if(releasing_, [&](const Releasing& one) {
    const Symmetric eps = strain(one.tetrahedron);
    const double share = release_->remaining(one.tetrahedron, phase_time - one.phase_time);
    const double before = residual_stiffness_.energy(one.tetrahedron, eps);
    residual_stiffness_.reduce(one.tetrahedron, share);
    changes_.push_back(one.tetrahedron);
    if (one.record)
      records_[*one.record].released_energy += before - residual_stiffness_.energy(one.tetrahedron, eps);
    return share <= 0;
  });
}

void BreakableBody::reduce(std::int32_t tetrahedron, double share, const Symmetric& strain, double load_time,
                           double phase_time, double ductility) {
  const double before = residual_stiffness_.energy(tetrahedron, strain);
  residual_stiffness_.soften(tetrahedron, share);
  changes_.push_back(tetrahedron);
  const std::size_t place = index(tetrahedron);
  if (subdomain_->owned[place] != 0)
    stiffness_reductions_.push_back({subdomain_->tetrahedron_number[place], load_time, phase_time,
                                     before - residual_stiffness_.energy(tetrahedron, strain), share,
                                     ductility});
}

void BreakableBody::open(std::int32_t tetrahedron, int cut, double remaining) {
  const auto index = static_cast<std::size_t>(tetrahedron);
  const mechanics::EdgeSet edges = release_->edges(cut);
  if (remaining > 0) {
    residual_stiffness_.begin_release(tetrahedron, edges);
    residual_stiffness_.reduce(tetrahedron, remaining);
    changes_.push_back(tetrahedron);
  } else {
    release_edges(tetrahedron, edges);
  }
  broken_[index] = 1;
  order_.push_back(tetrahedron);
  if (has_contact()) {
    residual_stiffness_.add_contact(tetrahedron, contact_normal(tetrahedron, cut));
  }
}

/// Pre-cracks are smooth, however the tessellation crosses them. What a tetrahedron keeps goes with its cut.
Vector BreakableBody::contact_normal(std::int32_t tetrahedron, int cut) const {
  const auto t = static_cast<std::size_t>(tetrahedron);
  const bool keeps_nothing = release_->edges(cut) == mechanics::all_edges;
  if (const auto& normals = subdomain_->pre_crack_normal; keeps_nothing && !normals.empty())
    if (const std::int32_t code = subdomain_->pre_crack[t]; code > 0)
      return normals[index(geometry::PreCrackCut::from(code).crack)];
  const Vector area = cut_areas(operators_.tetrahedra[t])[static_cast<std::size_t>(cut)];
  return area / norm(area);
}

void BreakableBody::release_edges(std::int32_t tetrahedron, mechanics::EdgeSet edges) {
  residual_stiffness_.release(tetrahedron, edges);
  changes_.push_back(tetrahedron);
}

void BreakableBody::restore(const Releases& releases, double phase_time) {
  for (const auto& fall : releases.stiffness_reductions) {
    const std::int32_t t = subdomain_->local_number(fall.tetrahedron);
    if (t < 0) continue;
    residual_stiffness_.soften(t, fall.share);
    changes_.push_back(t);
    release_->restore(t, fall.ductility);
    if (subdomain_->owned[static_cast<std::size_t>(t)] != 0) stiffness_reductions_.push_back(fall);
  }
  for (const auto& record : releases.breaks) {
    const std::int32_t t = subdomain_->local_number(record.tetrahedron);
    if (t < 0) continue;
    const bool is_counted = subdomain_->owned[static_cast<std::size_t>(t)] != 0;
    const double share = phase_time < infinity ? release_->remaining(t, phase_time - record.phase_time) : 0;
    open(t, record.cut, share);
    if (share > 0)
      releasing_.push_back(
          {t, record.phase_time, is_counted ? std::optional(records_.size()) : std::nullopt});
    if (is_counted) records_.push_back(record);
  }
  for (const auto& release : releases.bridge_releases) {
    const std::int32_t t = subdomain_->local_number(release.tetrahedron);
    if (t < 0) continue;
    release_edges(t, static_cast<mechanics::EdgeSet>(release.edges));
    if (subdomain_->owned[static_cast<std::size_t>(t)] != 0) bridge_releases_.push_back(release);
  }
  n_checked_ = order_.size();
}

std::vector<BreakableBody::BridgingEdge> BreakableBody::find_bridging_edges() const {
  std::vector<std::int32_t> edges;
  for (std::size_t i = n_checked_; i < order_.size(); ++i)
    for (const auto edge : edges_.of_tetrahedron(subdomain_->tetrahedra[static_cast<std::size_t>(order_[i])]))
      if (edge >= 0) edges.push_back(edge);
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<BridgingEdge> bridging;
  for (const auto edge : edges) {
    bool all_broken = true;
    std::vector<BridgingEdge> here;
    for (const auto t : edges_.round(edge)) {
      const auto index = static_cast<std::size_t>(t);
      const auto of_tetrahedron = edges_.of_tetrahedron(subdomain_->tetrahedra[index]);
      const auto k = std::ranges::find(of_tetrahedron, edge) - of_tetrahedron.begin();
      all_broken = all_broken && broken_[index] != 0;
      here.push_back({subdomain_->tetrahedron_number[index], k});
    }
    if (all_broken) bridging.insert(bridging.end(), here.begin(), here.end());
  }
  return bridging;
}

void BreakableBody::release_bridges(const parallel::Communicator& group, double load_time, double phase_time,
                                    const std::function<Symmetric(std::int32_t)>& strain) {
  if (!release_->opens_bridges()) return;
  // A rank does not see all tetrahedra around an edge between two ghosts: others report it.
  auto bridging = parallel::gather_found<BridgingEdge>(group, [&] {
    auto found = find_bridging_edges();
    n_checked_ = order_.size();
    return found;
  });
  std::ranges::sort(bridging);
  for (auto edge = bridging.begin(); edge != bridging.end();) {
    const std::int64_t number = edge->tetrahedron;
    unsigned edges = 0;
    for (; edge != bridging.end() && edge->tetrahedron == number; ++edge) edges |= 1U << edge->edge;
    const std::int32_t t = subdomain_->local_number(number);
    if (t < 0 || (edges & ~static_cast<unsigned>(residual_stiffness_.released_in_the_end(t))) == 0) continue;
    const Symmetric eps = strain(t);
    const double before = residual_stiffness_.energy(t, eps);
    release_edges(t, static_cast<mechanics::EdgeSet>(edges));
    if (subdomain_->owned[static_cast<std::size_t>(t)] != 0)
      bridge_releases_.push_back(
          {number, load_time, phase_time, before - residual_stiffness_.energy(t, eps), edges});
  }
}

const std::vector<std::array<std::int32_t, 4>>& BreakableBody::face_neighbours() const {
  if (face_neighbours_.empty()) face_neighbours_ = geometry::face_neighbours(subdomain_->tetrahedra);
  return face_neighbours_;
}

std::vector<double> BreakableBody::strain_energies(std::span<const double> displacement) const {
  return energies([&](std::int32_t t) { return strain(t, displacement); });
}

std::vector<double> BreakableBody::change_energies(std::span<const double> displacement) const {
  return energies([&](std::int32_t t) { return total_strain(t, displacement); });
}

template <class Strain>
std::vector<double> BreakableBody::energies(const Strain& strain) const {
  std::vector<double> energies;
  energies.reserve(operators_.tetrahedra.size());
  for (std::size_t i = 0; i < operators_.tetrahedra.size(); ++i) {
    const auto t = static_cast<std::int32_t>(i);
    if (subdomain_->owned[i] == 0) continue;
    if (!residual_stiffness_.carries(t) && !residual_stiffness_.has_contact(t)) continue;
    const Symmetric e = strain(t);
    // Nearly all tetrahedra are intact, so avoid a function call.
    if (residual_stiffness_.is_intact(t))
      energies.push_back(0.5 * operators_.tetrahedra[i].volume * mechanics::contract(intact_stress(t, e), e));
    else
      energies.push_back(residual_stiffness_.energy(t, e));
  }
  return energies;
}

std::vector<double> BreakableBody::released_energies() const {
  std::vector<double> energies;
  energies.reserve(records_.size() + bridge_releases_.size() + stiffness_reductions_.size());
  for (const auto& record : records_) energies.push_back(record.released_energy);
  for (const auto& fall : stiffness_reductions_) energies.push_back(fall.released_energy);
  for (const auto& release : bridge_releases_) energies.push_back(release.released_energy);
  return energies;
}

}  // namespace crackle::fracture
