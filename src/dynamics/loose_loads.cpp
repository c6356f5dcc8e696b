// SPDX-License-Identifier: GPL-3.0-or-later
#include "loose_loads.h"

#include "common/index.h"
#include "dynamics/separation.h"
#include "fracture/connectivity.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Maximum number of checks in a phase.
constexpr std::int64_t checks_per_phase = 200;
/// One in this many checks also considers breaks away from the loads.
constexpr std::int64_t near_checks_per_far_check = 10;

/// The share of a condition or support that acts on a piece.
struct OnPiece {
  std::int64_t condition;
  std::int64_t piece;
  std::int64_t share;        // of the loaded area that is still active, in units of 2^-48
  std::int64_t constrained;  // bit mask of the components in which the piece is constrained
};

/// Represents supports, drives and absorbing faces.
constexpr std::int64_t any_condition = -1;

/// Bit mask of the components in which each condition loads the body; without body forces, which go with a
/// fragment.
std::map<std::int64_t, std::int64_t> loaded_components(const mechanics::Conditions& loads) {
  std::map<std::int64_t, std::int64_t> components;
  for (const auto& pattern : loads.forces)
    if (!pattern.is_body_force) components[pattern.condition] |= 1 << pattern.component;
  return components;
}

std::vector<OnPiece> pieces_of_rank(const mechanics::Conditions& loads,
                                    const std::vector<std::int64_t>& labels) {
  std::map<std::pair<std::int64_t, std::int64_t>, OnPiece> found;
  const auto on_piece = [&](std::int64_t condition, std::int32_t node) -> OnPiece& {
    const std::int64_t piece = labels[index(node)];
    return found.try_emplace({condition, piece}, OnPiece{condition, piece, 0, 0}).first->second;
  };
  for (const auto& [c, components] : loaded_components(loads)) {
    const auto& condition = loads.conditions[index(c)];
    // Integers make the sums independent of the partition.
    for (std::size_t i = 0; i < condition.nodes.size(); ++i)
      if (condition.acts_at(i))
        on_piece(c, condition.nodes[i]).share += std::llrint(std::ldexp(condition.share[i], 48));
  }
  for (const auto& motion : loads.motions)
    for (const auto node : motion.nodes) on_piece(any_condition, node).constrained |= 1 << motion.component;
  for (const auto& support : loads.supports)
    on_piece(any_condition, support.node).constrained |= support.components;
  for (const auto& absorber : loads.absorbers)
    for (const auto node : absorber.nodes) on_piece(any_condition, node).constrained = 7;
  std::vector<OnPiece> list;
  for (const auto& [place, one] : found) list.push_back(one);
  return list;
}

using Pieces = std::set<std::int64_t>;

/// Loaded pieces large enough not to count as splinters. Collective.
Pieces sound_pieces(const parallel::Communicator& group, const fracture::BreakableBody& body,
                    const std::vector<std::int64_t>& labels, const std::vector<OnPiece>& all) {
  const auto& volume = body.operators().node_volume;
  // Integers make the sums independent of the partition.
  const double scale = std::ldexp(1.0, 48) / parallel::exact_sum(group, volume);
  Pieces sound;
  std::vector<std::int64_t> volumes;
  parallel::agree(group, [&] {
    for (const OnPiece& one : all)
      if (one.condition != any_condition) sound.insert(one.piece);
    const std::vector<std::int64_t> loaded(sound.begin(), sound.end());
    volumes.resize(loaded.size());
    for (std::size_t n = 0; n < volume.size(); ++n) {
      const auto place = std::ranges::lower_bound(loaded, labels[n]);
      if (place != loaded.end() && *place == labels[n])
        volumes[index(place - loaded.begin())] += std::llrint(volume[n] * scale);
    }
  });
  parallel::all_reduce(group, volumes, MPI_SUM);
  auto piece_volume = volumes.begin();
  std::erase_if(sound, [&](std::int64_t) {
    return std::ldexp(static_cast<double>(*piece_volume++), -48) < separated_share;
  });
  return sound;
}

/// The pieces on which each condition continues to act: those that are supported, and the one with the
/// largest share.
std::map<std::int64_t, Pieces> bearing_pieces(const mechanics::Conditions& loads,
                                              const std::vector<OnPiece>& all, const Pieces& sound) {
  std::map<std::int64_t, std::int64_t> constrained;
  std::map<std::int64_t, std::map<std::int64_t, std::int64_t>> shares;  // by condition and piece
  for (const OnPiece& one : all) {
    if (one.condition == any_condition)
      constrained[one.piece] |= one.constrained;
    else
      shares[one.condition][one.piece] += one.share;
  }
  std::map<std::int64_t, Pieces> bearing;
  for (const auto& [condition, components] : loaded_components(loads)) {
    std::int64_t largest = 0;
    std::optional<std::int64_t> main;
    for (const auto& [piece, share] : shares[condition]) {
      const auto components_of = constrained.find(piece);
      if (components_of != constrained.end() && (components_of->second & components) == components)
        bearing[condition].insert(piece);
      if (share <= largest || !sound.contains(piece)) continue;
      largest = share;
      main = piece;
    }
    if (main) bearing[condition].insert(*main);
  }
  return bearing;
}

/// The pieces connected by faces that touch a prescribed motion, or are not splinters. Collective.
/// @param labels of local tetrahedra, see fracture::face_piece_labels()
Pieces bearing_face_pieces(const parallel::Communicator& group, const fracture::BreakableBody& body,
                           const mechanics::Conditions& loads, const std::vector<std::int64_t>& labels,
                           const mechanics::NodeTetrahedra& around) {
  const auto& tetrahedra = body.operators().tetrahedra;
  const auto& counted = body.subdomain().owned;
  std::vector<double> volumes;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    if (counted[t] != 0) volumes.push_back(tetrahedra[t].volume);
  // Integers make the sums independent of the partition.
  const double scale = std::ldexp(1.0, 48) / parallel::exact_sum(group, volumes);
  const auto mine = parallel::agree(group, [&] {
    std::map<std::int64_t, std::array<std::int64_t, 2>> pieces;  // volume, and whether it is supported
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
      if (counted[t] != 0 && labels[t] >= 0)
        pieces[labels[t]][0] += std::llrint(tetrahedra[t].volume * scale);
    const auto support = [&](std::int32_t node) {
      for (const auto t : around[node])
        if (labels[index(t)] >= 0) pieces[labels[index(t)]][1] = 1;
    };
    for (const auto& motion : loads.motions) std::ranges::for_each(motion.nodes, support);
    for (const auto& one : loads.supports) support(one.node);
    std::vector<std::int64_t> flat;
    for (const auto& [label, piece] : pieces) flat.insert(flat.end(), {label, piece[0], piece[1]});
    return flat;
  });
  const auto all = parallel::gather_all<std::int64_t>(group, mine);
  return parallel::agree(group, [&] {
    std::map<std::int64_t, std::int64_t> volume;
    Pieces bearing;
    for (std::size_t i = 0; i < all.size(); i += 3) {
      volume[all[i]] += all[i + 1];
      if (all[i + 2] != 0) bearing.insert(all[i]);
    }
    for (const auto& [label, share] : volume)
      if (std::ldexp(static_cast<double>(share), -48) >= separated_share) bearing.insert(label);
    return bearing;
  });
}

}  // namespace

std::optional<mechanics::NodesOfConditions> nodes_of_loose_pieces(const parallel::Communicator& group,
                                                                  const fracture::BreakableBody& body,
                                                                  const mechanics::Conditions& loads,
                                                                  const std::vector<std::int64_t>& labels) {
  const auto mine = parallel::agree(group, [&] { return pieces_of_rank(loads, labels); });
  const auto all = parallel::gather_all<OnPiece>(group, mine);
  const auto sound = sound_pieces(group, body, labels, all);
  bool is_any = false;
  const auto nodes = parallel::agree(group, [&] {
    mechanics::NodesOfConditions loose(loads.conditions.size());
    auto bearing = bearing_pieces(loads, all, sound);
    for (const auto& [c, components] : loaded_components(loads)) {
      const auto& condition = loads.conditions[index(c)];
      for (std::size_t i = 0; i < condition.nodes.size(); ++i)
        if (condition.acts_at(i) && !bearing[c].contains(labels[index(condition.nodes[i])]))
          loose[index(c)].push_back(condition.nodes[i]);
      is_any = is_any || !loose[index(c)].empty();
    }
    return loose;
  });
  if (!parallel::any_of_all(group, is_any)) return std::nullopt;
  return nodes;
}

std::optional<mechanics::NodesOfConditions> nodes_of_falling_splinters(const parallel::Communicator& group,
                                                                       const fracture::BreakableBody& body,
                                                                       const mechanics::Conditions& loads) {
  if (std::ranges::none_of(loads.forces, &mechanics::ForcePattern::is_body_force)) return std::nullopt;
  const auto labels = fracture::face_piece_labels(group, body);
  const auto around = parallel::agree(group, [&] { return mechanics::node_tetrahedra(body.subdomain()); });
  const Pieces bearing = bearing_face_pieces(group, body, loads, labels, around);
  bool is_any = false;
  const auto nodes = parallel::agree(group, [&] {
    mechanics::NodesOfConditions falling(loads.conditions.size());
    for (const auto& pattern : loads.forces) {
      auto& of_condition = falling[index(pattern.condition)];
      if (!pattern.is_body_force || !of_condition.empty()) continue;
      const auto& condition = loads.conditions[index(pattern.condition)];
      for (std::size_t i = 0; i < condition.nodes.size(); ++i)
        if (condition.acts_at(i) && std::ranges::none_of(around[condition.nodes[i]], [&](std::int32_t t) {
              return bearing.contains(labels[index(t)]);
            }))
          of_condition.push_back(condition.nodes[i]);
      is_any = is_any || !of_condition.empty();
    }
    return falling;
  });
  if (!parallel::any_of_all(group, is_any)) return std::nullopt;
  return nodes;
}

std::vector<parallel::NumberedRows> gather_ended_loads(const parallel::Communicator& group,
                                                       const parallel::NodeLayout& layout,
                                                       const mechanics::Conditions& loads) {
  const auto has_ended = [](const mechanics::ConditionNodes& condition) {
    return !condition.has_ended.empty();
  };
  parallel::check_peers(group);
  if (!parallel::any_of_all(group, std::ranges::any_of(loads.conditions, has_ended))) return {};
  std::vector<parallel::NumberedRows> tables;
  for (const auto& condition : loads.conditions) {
    parallel::NumberedRows local;
    for (std::size_t i = 0; i < condition.has_ended.size(); ++i)
      if (condition.has_ended[i] != 0) local.add(layout.number[index(condition.nodes[i])], std::int64_t{1});
    tables.push_back(parallel::gather_rows(group, local));
  }
  return tables;
}

void restore_ended_loads(const parallel::Communicator& group, const parallel::NodeLayout& layout,
                         const std::vector<parallel::NumberedRows>& ended, mechanics::Conditions& loads) {
  if (ended.empty()) return;
  const auto nodes = parallel::agree(group, [&] {
    mechanics::NodesOfConditions found(loads.conditions.size());
    for (std::size_t c = 0; c < found.size(); ++c)
      for (const auto node : loads.conditions[c].nodes)
        if (!ended.at(c).find(layout.number[index(node)]).empty()) found[c].push_back(node);
    return found;
  });
  loads.end_loads(group, nodes);
}

LoadWatch::LoadWatch(const fracture::BreakableBody& body, const mechanics::Conditions& loads,
                     std::int64_t n_steps)
    : body_(&body),
      is_loaded_(body.subdomain().nodes.size()),
      interval_(std::max<std::int64_t>(1, n_steps / checks_per_phase)),
      has_loads_(!std::ranges::all_of(loads.forces, &mechanics::ForcePattern::is_body_force)) {
  for (const auto& pattern : loads.forces)
    if (!pattern.is_body_force)
      for (const auto node : pattern.nodes) is_loaded_[index(node)] = 1;
}

void LoadWatch::note(std::span<const std::int32_t> changed, std::int64_t step) {
  const auto is_loaded = [&](std::int32_t node) { return is_loaded_[index(node)] != 0; };
  for (const auto t : changed)
    if (body_->residual_stiffness().released(t) != 0 &&
        std::ranges::any_of(body_->subdomain().tetrahedra[index(t)], is_loaded))
      state_.broke_at = step;
}

bool LoadWatch::must_check(const parallel::Communicator& group, std::int64_t step, std::int64_t last_break) {
  std::array<std::int64_t, 2> last{state_.broke_at, last_break};
  parallel::all_reduce(group, last, MPI_MAX);
  const bool is_far_check = step % (near_checks_per_far_check * interval_) == 0;
  if (last[0] <= state_.checked_at && !(is_far_check && last[1] > state_.checked_at)) return false;
  state_.checked_at = step;
  return true;
}

LoadCheck LoadWatch::state(const parallel::Communicator& group) const {
  LoadCheck agreed = state_;
  agreed.broke_at = parallel::all_reduce(group, agreed.broke_at, MPI_MAX);
  return agreed;
}

}  // namespace crackle::dynamics
