// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"
#include "parallel/communicator.h"
#include "parallel/node_layout.h"
#include "parallel/numbered_rows.h"

#include "contact_search.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// How far nodes have moved since the last search for contact pairs, and how far they may get: most of them,
/// and the few that are much faster, such as splinters, whose ways would else set the margin of all.
class ContactPaces {
public:
  /// Steps between looks at how far nodes move.
  static constexpr std::int64_t steps_per_look = 8;

  /// The references must outlive the object. Local.
  /// @param n_local number of nodes, with ghosts
  ContactPaces(const parallel::Communicator& group, const parallel::NodeLayout& layout, std::size_t n_local)
      : group_(&group), layout_(&layout), is_fast_(n_local) {}

  /// A look: takes in that local nodes move like this in a step [m]. Collective; agrees before its messages.
  /// @param spacing of the mesh [m]
  /// @return whether the pairs must be found again, with the new margins()
  bool look(std::span<const Vector> movement, bool is_first, double spacing);

  ContactMargins margins() const { return {paces_[0].margin, paces_[1].margin, is_fast_}; }
  bool is_fast(std::int64_t number) const;                              ///< of a node of any rank
  double moved(bool fast) const { return paces_[fast ? 1 : 0].moved; }  ///< since the search, at most [m]
  double reach(bool fast) const { return paces_[fast ? 1 : 0].reach; }  ///< until the next look [m]

  /// Bits of a checkpoint, equal on every rank.
  std::vector<std::int64_t> words() const;
  static constexpr std::size_t n_words = 6;
  parallel::NumberedRows fast_nodes() const;
  void restore(std::span<const std::int64_t> words, const parallel::NumberedRows& fast_nodes);

private:
  struct Pace {
    double margin = 0;    // of the search [m]
    double moved = 0;     // since the search, at most, as far as is known [m]
    double reach = 0;     // from there until the next look [m]
    double farthest = 0;  // in the last step, of all ranks [m]
  };

  void find_farthest(std::span<const Vector> movement);
  void find_fast(std::span<const Vector> movement);
  void mark_fast();

  const parallel::Communicator* group_;
  const parallel::NodeLayout* layout_;
  std::array<Pace, 2> paces_{};        // of most nodes and of all
  std::vector<std::int64_t> fast_;     // the nodes that only the latter bounds, of all ranks, ascending
  std::vector<std::uint8_t> is_fast_;  // each local node
};

}  // namespace crackle::dynamics
