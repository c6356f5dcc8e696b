// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace crackle::ensemble {

/// Roles of the ranks: rank 0 is the master, followed by groups of `ranks_per_group` consecutive ranks that
/// share one sample each; ranks that do not fill a group stay idle until the final collective. If all ranks
/// form one group, its root is also the master.
struct GroupLayout {
  int n_ranks = 1;
  int ranks_per_group = 1;
  int n_groups = 1;
  int n_left_over = 0;

  bool shared() const { return n_ranks == ranks_per_group; }
  /// Group of a rank; -1 for the master and for leftover ranks.
  int group_of(int rank) const;
  /// The lowest rank of a group; it communicates with the master.
  int root_of(int group) const { return shared() ? 0 : 1 + group * ranks_per_group; }
};

/// @throws std::runtime_error stating the number of ranks needed, when there are too few for one group
GroupLayout make_group_layout(int n_ranks, int ranks_per_sample);

/// One line for the log: ranks, master, groups, leftover ranks.
std::string describe(const GroupLayout& layout);

}  // namespace crackle::ensemble
