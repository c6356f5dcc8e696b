// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/group_layout.h"

#include "crackle/common/failure.h"

#include <fmt/format.h>

namespace crackle::ensemble {

int GroupLayout::group_of(int rank) const {
  if (shared()) return 0;
  if (rank == 0) return -1;
  const int group = (rank - 1) / ranks_per_group;
  return group < n_groups ? group : -1;
}

GroupLayout make_group_layout(int n_ranks, int ranks_per_sample) {
  if (n_ranks == 1) return {};
  if (n_ranks < 1 + ranks_per_sample) {
    fail(
        "ensemble.ranks_per_sample = {0} needs at least {1} ranks (a master and one group of {0}), "
        "but there are {2}; start {1} or more, or 1",
        ranks_per_sample, 1 + ranks_per_sample, n_ranks);
  }
  GroupLayout layout;
  layout.n_ranks = n_ranks;
  layout.ranks_per_group = ranks_per_sample;
  layout.n_groups = (n_ranks - 1) / ranks_per_sample;
  layout.n_left_over = (n_ranks - 1) % ranks_per_sample;
  return layout;
}

std::string describe(const GroupLayout& layout) {
  if (layout.shared()) return "1 rank: master and worker in one";
  std::string line = fmt::format("{} ranks: master on rank 0, {} group{} of {}", layout.n_ranks,
                                 layout.n_groups, layout.n_groups == 1 ? "" : "s", layout.ranks_per_group);
  if (layout.n_left_over > 0) {
    const int first = layout.n_ranks - layout.n_left_over;
    line += layout.n_left_over == 1
                ? fmt::format("; rank {} is left over and stays idle", first)
                : fmt::format("; ranks {} to {} are left over and stay idle", first, layout.n_ranks - 1);
  }
  return line;
}

}  // namespace crackle::ensemble
