// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "mechanics/tensor.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace crackle::mechanics {

/// A stiffness that holds a node in its place, such as that of a spring [N/m].
struct NodeStiffness {
  std::int32_t node = 0;  ///< owned local node
  Symmetric stiffness{};

  /// By which the node is held. @param displacement three numbers of each node [m]
  template <class Real>
  Vector force(std::span<Real> displacement) const {
    const auto u = displacement.subspan(index(node, 0), 3);
    return mechanics::apply(
        stiffness, {static_cast<double>(u[0]), static_cast<double>(u[1]), static_cast<double>(u[2])});
  }
  bool operator==(const NodeStiffness&) const = default;
};

/// Adds the forces of all nodes. @param force three numbers of each node [N]
inline void add_forces(std::span<const NodeStiffness> nodes, std::span<const double> displacement,
                       std::span<double> force) {
  for (const NodeStiffness& one : nodes) {
    const Vector f = one.force(displacement);
    for (std::size_t i = 0; i < 3; ++i) force[index(one.node, 0) + i] += f[i];
  }
}

/// Displacement components of an owned node that something besides the boundary conditions holds: bit i for
/// component i.
struct Support {
  std::int32_t node = 0;
  std::uint8_t components = 7;
};

}  // namespace crackle::mechanics
