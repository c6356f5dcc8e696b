// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/parting_watch.h"

#include "common/disjoint_sets.h"
#include "common/index.h"
#include "dynamics/separation.h"
#include "fracture/connectivity.h"
#include "geometry/dual_facets.h"
#include "parallel/agreement.h"
#include "parallel/ghost_exchange.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Number of tetrahedra among which a way round a break is sought. Some 100 share a node with one.
constexpr std::size_t patch_size = 250;

/// True if the members that count are all in one set.
template <class Counts>
bool are_together(DisjointSets& sets, std::span<const std::size_t> members, const Counts& counts) {
  std::optional<std::size_t> common;
  for (const auto i : members) {
    if (!counts(i)) continue;
    if (common && sets.smallest(i) != *common) return false;
    common = sets.smallest(i);
  }
  return true;
}

}  // namespace

PartingWatch::PartingWatch(const parallel::Communicator& group, const fracture::BreakableBody& body,
                           const mechanics::Conditions& loads)
    : body_(&body) {
  const auto& subdomain = body.subdomain();
  parallel::GhostExchange<std::uint8_t> exchange(group, subdomain.layout);
  parallel::agree(group, [&] {
    is_loaded_.resize(subdomain.nodes.size());
    node_place_.assign(subdomain.nodes.size(), -1);
    place_.assign(index(subdomain.n_tetrahedra()), -1);
    released_.resize(index(subdomain.n_tetrahedra()));
    for (const auto& pattern : loads.forces)
      if (!pattern.is_body_force)
        for (const auto node : pattern.nodes) is_loaded_[index(node)] = 1;
    for (const auto& motion : loads.motions)
      for (const auto node : motion.nodes) is_loaded_[index(node)] = 1;
    for (const auto& support : loads.supports) is_loaded_[index(support.node)] = 1;
  });
  exchange.update(is_loaded_);
  const auto& volumes = body.operators().node_volume;
  small_ = separated_share * std::accumulate(volumes.begin(), volumes.end(), 0.0);
}

void PartingWatch::note(std::span<const std::int32_t> changed) {
  // Gradual releases change the stiffness in many steps, and the edges that carry load in the last one.
  for (const auto t : changed)
    if (body_->residual_stiffness().released(t) != released_[index(t)]) changed_.push_back(t);
}

bool PartingWatch::may_have_parted() {
  const auto now = [this](std::int32_t t) { return body_->residual_stiffness().released(t); };
  auto changed = std::exchange(changed_, {});
  if (!std::exchange(is_known_, true)) {
    for (std::size_t t = 0; t < released_.size(); ++t) released_[t] = now(static_cast<std::int32_t>(t));
    return true;
  }
  // In one order on all ranks. Local numbers ascend with those in the realization.
  std::ranges::sort(changed);
  bool may_have_parted = false;
  for (const auto t : changed)
    if (std::exchange(released_[index(t)], now(t)) != now(t) && body_->subdomain().owned[index(t)] != 0)
      may_have_parted = may_have_parted || this->may_have_parted(t);
  return may_have_parted;
}

bool PartingWatch::may_have_parted(std::int32_t tetrahedron) {
  find_patch(tetrahedron);
  const bool is_certain = are_faces_connected() && are_nodes_connected();
  for (const auto t : patch_) place_[index(t)] = -1;
  for (const auto node : nodes_) node_place_[index(node)] = -1;
  return !is_certain;
}

/// Tetrahedra round one, whether they carry load or not, nearest first.
void PartingWatch::find_patch(std::int32_t tetrahedron) {
  const auto add = [](std::int32_t item, std::vector<std::int32_t>& list, std::vector<std::int32_t>& place) {
    if (place[index(item)] >= 0) return;
    place[index(item)] = static_cast<std::int32_t>(list.size());
    list.push_back(item);
  };
  patch_.clear();
  add(tetrahedron, patch_, place_);
  for (std::size_t next = 0; next < patch_.size() && patch_.size() < patch_size; ++next)
    for (const std::int32_t other : body_->face_neighbours()[index(patch_[next])])
      if (other >= 0) add(other, patch_, place_);
  nodes_.clear();
  for (const auto t : patch_)
    for (const auto node : body_->subdomain().tetrahedra[index(t)]) add(node, nodes_, node_place_);
}

/// True if the first tetrahedron and its neighbours, as far as any face still connects them, are connected,
/// and no condition acts on the others.
bool PartingWatch::are_faces_connected() const {
  const auto& neighbours = body_->face_neighbours();
  const auto released = [this](std::int32_t t) { return released_[index(t)]; };
  DisjointSets sets(patch_.size());
  std::vector<std::uint8_t> has_link(patch_.size());
  for (std::size_t i = 0; i < patch_.size(); ++i)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      if (!fracture::is_connected_across(*body_, patch_[i], corner, released)) continue;
      has_link[i] = 1;
      if (const auto other = place_[index(neighbours[index(patch_[i])][corner])]; other >= 0)
        sets.join(i, index(other));
    }
  std::vector<std::size_t> members{0};
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const std::int32_t neighbour = neighbours[index(patch_.front())][corner];
    if (neighbour >= 0)
      members.push_back(index(place_[index(neighbour)]));
    else if (!owns_any(patch_.front(), corner))
      return false;  // another rank may hold the neighbour
  }
  const bool is_any_loaded =
      std::ranges::any_of(members, [&](std::size_t i) { return has_link[i] == 0 && is_loaded(patch_[i]); });
  return !is_any_loaded && are_together(sets, members, [&](std::size_t i) { return has_link[i] != 0; });
}

/// True if the nodes of the first one are connected, but for small pieces that lie in the patch.
bool PartingWatch::are_nodes_connected() const {
  const auto& tetrahedra = body_->subdomain().tetrahedra;
  const auto place = [&](std::int32_t t, std::size_t corner) {
    return index(node_place_[index(tetrahedra[index(t)][corner])]);
  };
  DisjointSets sets(nodes_.size());
  std::vector<std::uint8_t> is_at_border(nodes_.size());
  for (const auto t : patch_) {
    const mechanics::EdgeSet released = released_[index(t)];
    for (std::size_t k = 0; k < 6; ++k) {
      const auto [a, b] = geometry::dual_facet_nodes[k];
      if (((released >> k) & 1) == 0) sets.join(place(t, a), place(t, b));
    }
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const std::int32_t other = body_->face_neighbours()[index(t)][corner];
      if (other < 0 || place_[index(other)] >= 0) continue;
      for (std::size_t c = 0; c < 4; ++c)
        if (c != corner) is_at_border[place(t, c)] = 1;
    }
  }
  std::vector<std::uint8_t> counts(nodes_.size());
  std::vector<double> volume(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const auto set = sets.smallest(i);
    if (is_at_border[i] != 0 || !may_come_off(nodes_[i]))
      counts[set] = 1;
    else if ((volume[set] += body_->operators().node_volume[index(nodes_[i])]) >= small_)
      counts[set] = 1;
  }
  constexpr std::array<std::size_t, 4> own{0, 1, 2, 3};
  return are_together(sets, own, [&](std::size_t i) { return counts[sets.smallest(i)] != 0; });
}

bool PartingWatch::is_loaded(std::int32_t tetrahedron) const {
  return std::ranges::any_of(body_->subdomain().tetrahedra[index(tetrahedron)],
                             [this](std::int32_t node) { return is_loaded_[index(node)] != 0; });
}

/// True if this rank owns a node of the face opposite a corner.
bool PartingWatch::owns_any(std::int32_t tetrahedron, std::size_t corner) const {
  const auto& subdomain = body_->subdomain();
  for (std::size_t a = 0; a < 4; ++a)
    if (a != corner && subdomain.tetrahedra[index(tetrahedron)][a] < subdomain.layout.n_owned) return true;
  return false;
}

/// True for a node that this rank sees whole and on which no condition acts.
bool PartingWatch::may_come_off(std::int32_t node) const {
  return node < body_->subdomain().layout.n_owned && is_loaded_[index(node)] == 0;
}

}  // namespace crackle::dynamics
