// SPDX-License-Identifier: GPL-3.0-or-later
#include "ghost_displacements.h"

#include "common/index.h"
#include "common/real.h"
#include "common/stopwatch.h"

#include <algorithm>

namespace crackle::dynamics {

template <class Real>
GhostDisplacements<Real>::GhostDisplacements(const parallel::Communicator& group,
                                             const parallel::NodeLayout& layout,
                                             std::span<kernels::NodeRecord<Real>> nodes,
                                             std::span<kernels::Movement<double>> movement,
                                             std::size_t nodes_per_block)
    : nodes_(nodes),
      ghosts_(nodes.subspan(static_cast<std::size_t>(layout.n_owned))),
      movement_(movement),
      nodes_per_block_(nodes_per_block) {
  if (group.size() > 1) exchange_.emplace(group, layout);
}

template <class Real>
std::span<const std::int32_t> GhostDisplacements<Real>::sent_nodes() const {
  return exchange_ ? exchange_->sent_nodes() : std::span<const std::int32_t>{};
}

template <class Real>
void GhostDisplacements<Real>::begin() {
  if (!exchange_) return;
  end();
  const Stopwatch watch;
  const auto sent = exchange_->sent_nodes();
  for (std::size_t i = 0; i < sent.size(); ++i)
    std::copy_n(nodes_[index(sent[i])].displacement, 3, exchange_->sent()[i].begin());
  exchange_->begin();
  is_under_way_ = true;
  seconds_ += watch.seconds();
}

template <class Real>
void GhostDisplacements<Real>::end() {
  if (!is_under_way_) return;
  const Stopwatch watch;
  exchange_->end();
  is_under_way_ = false;
  seconds_ += watch.seconds();
  const auto received = exchange_->received();
  for (std::size_t begin = 0; begin < ghosts_.size(); begin += nodes_per_block_) {
    auto& movement = movement_[begin / nodes_per_block_];
    for (std::size_t c = 0; c < 3; ++c) {
      double low = infinity, high = -low;
      for (std::size_t i = begin; i < std::min(begin + nodes_per_block_, ghosts_.size()); ++i) {
        auto& place = ghosts_[i].displacement[c];
        const auto displacement = static_cast<double>(kernels::difference(received[i][c], place));
        low = std::min(low, displacement);
        high = std::max(high, displacement);
        place = received[i][c];
      }
      movement.low[c] += low;
      movement.high[c] += high;
    }
  }
}

template <class Real>
ExchangeCost GhostDisplacements<Real>::exchange_cost() const {
  if (!exchange_) return {};
  return {exchange_->n_exchanges(), exchange_->bytes_per_exchange(), seconds_};
}

template class GhostDisplacements<float>;
template class GhostDisplacements<double>;

}  // namespace crackle::dynamics
