// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/sample_result.h"
#include "kernels/kernels.h"
#include "parallel/ghost_exchange.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace crackle::dynamics {

/// Exchanges ghost displacements in node records: they are sent as soon as their owners have moved, and
/// awaited only when needed. A group of one rank never communicates.
template <class Real>
class GhostDisplacements {
public:
  /// Collective. The references must outlive the object.
  /// @param nodes records of the local nodes
  /// @param movement of each block of ghosts, extended by received updates
  GhostDisplacements(const parallel::Communicator& group, const parallel::NodeLayout& layout,
                     std::span<kernels::NodeRecord<Real>> nodes,
                     std::span<kernels::Movement<double>> movement, std::size_t nodes_per_block);

  /// The owned nodes that are ghosts elsewhere, ascending.
  std::span<const std::int32_t> sent_nodes() const;

  void begin();  ///< Collective. Ends the previous exchange first.
  void end();    ///< Collective if an exchange is under way.

  ExchangeCost exchange_cost() const;

private:
  std::span<kernels::NodeRecord<Real>> nodes_;
  std::span<kernels::NodeRecord<Real>> ghosts_;
  std::span<kernels::Movement<double>> movement_;
  std::size_t nodes_per_block_;
  std::optional<parallel::GhostExchange<std::array<kernels::Integer<Real>, 3>>> exchange_;
  bool is_under_way_ = false;
  double seconds_ = 0;
};

}  // namespace crackle::dynamics
