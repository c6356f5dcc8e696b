// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/separation.h"

#include "common/index.h"
#include "fracture/connectivity.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

namespace crackle::dynamics {

namespace {

using Pieces = std::set<std::int64_t>;

/// The pieces on which each condition acts: force patterns first, then prescribed motions, then all other
/// supports together. Collective.
/// @param pieces_at calls its second argument with the label of every piece at an owned node
template <class PiecesAt>
std::vector<Pieces> pieces_of_conditions(const parallel::Communicator& group,
                                         const mechanics::Conditions& loads, const PiecesAt& pieces_at) {
  const std::size_t n_conditions = loads.forces.size() + loads.motions.size() + 1;
  // There are few pieces, but each label is known only on the ranks with its nodes, so gather them.
  const auto mine = parallel::agree(group, [&] {
    std::set<std::pair<std::int64_t, std::int64_t>> found;
    const auto add = [&](std::size_t condition, std::int32_t node) {
      pieces_at(node,
                [&](std::int64_t label) { found.emplace(static_cast<std::int64_t>(condition), label); });
    };
    for (std::size_t k = 0; k < loads.forces.size(); ++k)
      for (std::size_t i = 0; i < loads.forces[k].nodes.size(); ++i)
        if (loads.forces[k].weight[i] != 0) add(k, loads.forces[k].nodes[i]);
    for (std::size_t k = 0; k < loads.motions.size(); ++k)
      for (const auto node : loads.motions[k].nodes) add(loads.forces.size() + k, node);
    for (const auto& support : loads.supports) add(n_conditions - 1, support.node);
    std::vector<std::int64_t> flat;
    for (const auto& [condition, piece] : found) flat.insert(flat.end(), {condition, piece});
    return flat;
  });
  const auto all = parallel::gather_all<std::int64_t>(group, mine);
  return parallel::agree(group, [&] {
    std::vector<Pieces> pieces(n_conditions);
    for (std::size_t i = 0; i < all.size(); i += 2) pieces[index(all[i])].insert(all[i + 1]);
    return pieces;
  });
}

/// Pieces connected by edges that still carry load.
std::vector<Pieces> pieces_of_conditions(const parallel::Communicator& group,
                                         const mechanics::Conditions& loads,
                                         const std::vector<std::int64_t>& labels) {
  return pieces_of_conditions(group, loads,
                              [&](std::int32_t node, const auto& see) { see(labels[index(node)]); });
}

/// Pieces connected by faces that still carry load: a node may belong to several.
std::vector<Pieces> face_pieces_of_conditions(const parallel::Communicator& group,
                                              const fracture::BreakableBody& body,
                                              const mechanics::Conditions& loads) {
  const auto labels = fracture::face_piece_labels(group, body);
  const auto labels_at = parallel::agree(group, [&] {
    std::unordered_map<std::int32_t, std::vector<std::int64_t>> at;
    std::vector<std::uint8_t> has_condition(body.subdomain().nodes.size());
    const auto mark = [&](const auto& conditions) {
      for (const auto& condition : conditions)
        for (const auto node : condition.nodes) has_condition[index(node)] = 1;
    };
    mark(loads.forces);
    mark(loads.motions);
    for (const auto& support : loads.supports) has_condition[index(support.node)] = 1;
    for (std::size_t t = 0; t < labels.size(); ++t)
      for (const auto node : body.subdomain().tetrahedra[t])
        if (has_condition[index(node)] != 0 && labels[t] >= 0) at[node].push_back(labels[t]);
    return at;
  });
  return pieces_of_conditions(group, loads, [&](std::int32_t node, const auto& see) {
    if (const auto found = labels_at.find(node); found != labels_at.end())
      for (const auto label : found->second) see(label);
  });
}

bool have_common_piece(const Pieces& a, const Pieces& b) {
  return std::ranges::any_of(a, [&](std::int64_t piece) { return b.contains(piece); });
}

/// True if two conditions have no common piece.
bool act_apart(const mechanics::Conditions& loads, const std::vector<Pieces>& conditions) {
  const auto input_condition = [&](std::size_t k) {
    return k < loads.forces.size() ? loads.forces[k].condition
                                   : loads.motions[k - loads.forces.size()].condition;
  };
  const auto is_body_force = [&](std::size_t k) {
    return k < loads.forces.size() && loads.forces[k].is_body_force;
  };
  for (std::size_t a = 0; a + 1 < conditions.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      // The components of a load that has ended everywhere act on no piece at all; body forces act on all
      // pieces.
      if (!is_body_force(a) && !is_body_force(b) && !have_common_piece(conditions[a], conditions[b]) &&
          input_condition(a) != input_condition(b))
        return true;
  return false;
}

/// True if each condition acts on a piece with a prescribed motion, or with a fix if there is any; a body
/// force on such pieces only.
bool are_supported(const mechanics::Conditions& loads, const std::vector<Pieces>& conditions) {
  const bool any_fixed = std::ranges::any_of(loads.motions, &mechanics::PrescribedMotion::is_fixed);
  Pieces supported;
  for (std::size_t m = 0; m < loads.motions.size(); ++m)
    if (loads.motions[m].is_fixed || !any_fixed) supported.merge(Pieces(conditions[loads.forces.size() + m]));
  supported.merge(Pieces(conditions.back()));
  for (std::size_t k = 0; k + 1 < conditions.size(); ++k) {
    const bool on_all = k < loads.forces.size() && loads.forces[k].is_body_force;
    if (on_all ? !std::ranges::includes(supported, conditions[k])
               : !have_common_piece(conditions[k], supported))
      return false;
  }
  return true;
}

/// The two largest pieces.
struct LargestPieces {
  std::int64_t main = 0;    ///< label of the largest
  double second_share = 0;  ///< volume of the second largest, as a share of the body's
};

/// Collective.
LargestPieces largest_pieces(const parallel::Communicator& group, const fracture::BreakableBody& body,
                             const std::vector<std::int64_t>& labels) {
  const auto& volume = body.operators().node_volume;
  const double total = parallel::exact_sum(group, volume);
  // Integers make the sums independent of the partition.
  const double scale = std::ldexp(1.0, 48) / total;
  const auto mine = parallel::agree(group, [&] {
    std::map<std::int64_t, std::int64_t> sums;
    std::int64_t* sum = nullptr;  // of the piece of the node before
    for (std::size_t n = 0; n < volume.size(); ++n) {
      if (n == 0 || labels[n] != labels[n - 1]) sum = &sums[labels[n]];
      *sum += std::llrint(volume[n] * scale);
    }
    std::vector<std::int64_t> flat;
    for (const auto& [piece, sum] : sums) flat.insert(flat.end(), {piece, sum});
    return flat;
  });
  const auto all = parallel::gather_all<std::int64_t>(group, mine);
  return parallel::agree(group, [&] {
    std::map<std::int64_t, std::int64_t> sums;
    for (std::size_t i = 0; i < all.size(); i += 2) sums[all[i]] += all[i + 1];
    LargestPieces pieces;
    std::int64_t largest = 0, second = 0;
    for (const auto& [piece, sum] : sums) {
      second = std::max(second, std::min(sum, largest));
      if (sum > largest) pieces.main = piece;
      largest = std::max(largest, sum);
    }
    pieces.second_share = std::ldexp(static_cast<double>(second), -48);
    return pieces;
  });
}

/// True if the body has prescribed motions, but neither they nor loads act on its largest piece any more:
/// what is left at their nodes may be less than a loose piece.
bool has_come_off(const mechanics::Conditions& loads, const std::vector<Pieces>& conditions,
                  std::int64_t main_piece) {
  bool is_prescribed = false;
  for (std::size_t k = 0; k < conditions.size(); ++k) {
    const bool is_force = k < loads.forces.size();
    if (is_force && loads.forces[k].is_body_force) continue;
    if (conditions[k].contains(main_piece)) return false;
    if (!is_force && !conditions[k].empty()) is_prescribed = true;
  }
  return is_prescribed;
}

}  // namespace

bool is_unloaded(const parallel::Communicator& group, const fracture::BreakableBody& body,
                 const mechanics::Conditions& loads, const std::vector<std::int64_t>& labels) {
  std::set<int> acting;
  for (const auto& pattern : loads.forces)
    if (!pattern.is_body_force) acting.insert(pattern.condition);
  for (const auto& motion : loads.motions) acting.insert(motion.condition);
  if (acting.size() < 2) return is_separated(group, body, loads, labels);
  if (act_apart(loads, face_pieces_of_conditions(group, body, loads))) return true;
  return has_come_off(loads, pieces_of_conditions(group, loads, labels),
                      largest_pieces(group, body, labels).main);
}

bool is_separated(const parallel::Communicator& group, const fracture::BreakableBody& body,
                  const mechanics::Conditions& loads) {
  return is_separated(group, body, loads, fracture::piece_labels(group, body));
}

bool is_separated(const parallel::Communicator& group, const fracture::BreakableBody& body,
                  const mechanics::Conditions& loads, const std::vector<std::int64_t>& labels) {
  const auto conditions = pieces_of_conditions(group, loads, labels);
  if (act_apart(loads, conditions)) return true;
  const LargestPieces pieces = largest_pieces(group, body, labels);
  return pieces.second_share >= separated_share || has_come_off(loads, conditions, pieces.main);
}

std::vector<std::int32_t> nodes_of_loose_pieces_at(const parallel::Communicator& group,
                                                   const fracture::BreakableBody& body,
                                                   const mechanics::Conditions& loads,
                                                   const std::vector<std::int64_t>& labels,
                                                   const std::vector<std::int32_t>& nodes) {
  const auto conditions = pieces_of_conditions(group, loads, labels);
  const std::int64_t main = largest_pieces(group, body, labels).main;
  const bool is_apart = is_separated(group, body, loads, labels);
  const auto mine = parallel::agree(group, [&] {
    Pieces at;
    for (const auto node : nodes) at.insert(labels[index(node)]);
    return std::vector<std::int64_t>(at.begin(), at.end());
  });
  const auto all = parallel::gather_all<std::int64_t>(group, mine);
  return parallel::agree(group, [&] {
    Pieces loose(all.begin(), all.end());
    if (!is_apart) loose.erase(main);
    for (std::size_t k = loads.forces.size(); k < conditions.size(); ++k)
      for (const auto held : conditions[k]) loose.erase(held);
    std::vector<std::int32_t> found;
    for (std::size_t n = 0; n < labels.size(); ++n)
      if (loose.contains(labels[n])) found.push_back(static_cast<std::int32_t>(n));
    return found;
  });
}

bool loads_are_supported(const parallel::Communicator& group, const fracture::BreakableBody& body,
                         const mechanics::Conditions& loads, const std::vector<std::int64_t>& labels) {
  if (loads.motions.empty() && !loads.has_supports) return !is_separated(group, body, loads, labels);
  return are_supported(loads, pieces_of_conditions(group, loads, labels));
}

bool loads_are_supported_by_faces(const parallel::Communicator& group, const fracture::BreakableBody& body,
                                  const mechanics::Conditions& loads) {
  if (loads.motions.empty() && !loads.has_supports) return !is_separated(group, body, loads);
  return are_supported(loads, face_pieces_of_conditions(group, body, loads));
}

}  // namespace crackle::dynamics
