// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/breakable_body.h"
#include "fracture/equivalent_stress.h"

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace crackle::fracture {

/// Stress over strength, averaged over a ball of fixed radius around a tetrahedron's centroid.
///
/// The weight of a tetrahedron with volume V at the distance r is V (1 - r^2 / l^2)^2 (Bazant and Jirasek,
/// Nonlocal integral formulations of plasticity and damage, J. Eng. Mech. 128, 2002). The ball contains the
/// unbroken tetrahedra that can be reached from its centre through common faces inside it, so that no stress
/// is averaged across a free surface or a crack. Broken tetrahedra at its boundary count as stress-free. It
/// ends where the material or the interface does: the average over a thin weak bond and its stronger
/// neighbours would exceed the strength at a higher load only.
///
/// An average can only exceed the strength if some tetrahedron in the ball exceeds its own, since the
/// equivalent stress is convex.
///
/// Averages vary little over a fraction of the radius, so one ball represents what a cell of a grid contains
/// of one material or interface; with a cell size of a third of the radius, beyond that resolution the number
/// of balls does not grow with mesh refinement.
class StressAverage {
public:
  struct Share {
    std::int32_t tetrahedron;
    double weight;  ///< relative to the strength [1/Pa]; weights times strengths add up to 1 if nothing is
                    ///< broken
  };

  /// The same average for displacements: with one elasticity, that of stress is the elastic stress of the sum
  /// of gradient (x) displacement over the nodes, a fifth of the tetrahedra.
  struct NodeShares {
    std::vector<std::int32_t> nodes;
    std::vector<Vector> gradients;  ///< of each node: the sum of weight times gradient [1/(Pa m)]
    std::size_t size() const { return nodes.size(); }
  };

  /// @param body, strengths must outlive the object
  /// @param strengths of each local tetrahedron [Pa]
  /// @param length radius of the ball [m]
  StressAverage(const BreakableBody& body, std::span<const double> strengths, double length);

  /// The centre of the ball that represents the cell of a tetrahedron: the unbroken tetrahedron of the same
  /// material and interface whose centroid is nearest to the centre of the cell.
  /// @pre unbroken, and the rank counts a tetrahedron in the same cell
  std::int32_t centre(std::int32_t tetrahedron);

  /// The unbroken tetrahedra in the ball around one that this rank counts, in the same order on all ranks.
  /// Valid until the next call.
  /// @pre the subdomain has a halo of this length, see geometry::split()
  std::span<const Share> ball(std::int32_t centre);

  /// The ball() by nodes. Sums over it differ from those over tetrahedra by rounding.
  const NodeShares& node_shares(std::int32_t centre);

  /// @param stress of a local tetrahedron: a mechanics::Symmetric [Pa]
  /// @return relative to the strength; a tensor whose equivalent stress is 1 when the ball is at its strength
  template <class Stress>
  mechanics::Symmetric operator()(std::int32_t centre, const Stress& stress) {
    mechanics::Symmetric sum{};
    for (const auto& [tetrahedron, weight] : ball(centre)) {
      const mechanics::Symmetric& sigma = stress(tetrahedron);
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * sigma[i];
    }
    return sum;
  }

  /// The tetrahedron that breaks when the ball around `centre` fails: the one with the largest equivalent
  /// stress over strength, or the lowest number if equal. Thus breaks attach to the crack, and no bridges
  /// remain behind its tip.
  template <class Stress>
  std::int32_t most_stressed(std::int32_t centre, const EquivalentStress& value, const Stress& stress) {
    const auto all = ball(centre);
    const auto bound = [&](std::int32_t t) { return value.bound(stress(t)) / strengths_[index(t)]; };
    std::int32_t most = centre;
    double highest_bound = bound(centre);
    for (const auto& [t, weight] : all)
      if (const double of_this = bound(t); of_this > highest_bound) {
        highest_bound = of_this;
        most = t;
      }
    double largest = value(stress(most)) / strengths_[index(most)];
    for (const auto& [t, weight] : all) {
      const mechanics::Symmetric& sigma = stress(t);
      const double strength = strengths_[index(t)];
      // The bound rules out nearly all of them; tolerance for rounding.
      if (value.bound(sigma) < largest * strength * (1 - 1e-9) - EquivalentStress::rounding(sigma)) continue;
      const double load = value(sigma) / strength;
      if (load < largest || (load == largest && t >= most)) continue;
      largest = load;
      most = t;
    }
    return most;
  }

  /// Announces that the strengths of these local tetrahedra have changed.
  void forget(std::span<const std::int32_t> tetrahedra);

private:
  /// Balls by their centres, until one of their tetrahedra changes or there are too many.
  template <class Ball>
  struct Cache {
    std::unordered_map<std::int32_t, Ball> of_centre;
    std::size_t n_shares = 0;
  };
  template <class Ball, class Find>
  const Ball& find_in(Cache<Ball>& cache, std::int32_t centre, const Find& find);
  template <class Ball>
  void forget_in(Cache<Ball>& cache, std::span<const std::int32_t> tetrahedra) const;

  void find_cells();
  void forget_broken();
  std::vector<Share> find_ball(std::int32_t centre);
  NodeShares find_node_shares(std::int32_t centre);

  const BreakableBody* body_;
  std::span<const double> strengths_;
  double length_;
  std::vector<geometry::Point> centroid_;
  std::vector<std::int32_t> cell_;         // of each tetrahedron
  std::vector<std::int32_t> in_cell_;      // tetrahedra, cell by cell
  std::vector<std::int32_t> first_;        // index in in_cell_ of the first one of each cell, plus one entry
  std::vector<std::int32_t> cell_centre_;  // centre of each cell; -1: not searched since the last break
  std::vector<std::array<std::int32_t, 4>> neighbour_;  // across the face opposite to each corner; -1: none
  std::vector<std::int32_t> reached_by_;  // number of the last search that reached the tetrahedron
  std::int32_t n_searches_ = 0;
  Cache<std::vector<Share>> balls_;
  Cache<NodeShares> node_shares_;
  std::vector<std::int32_t> place_of_node_;  // in the ball under search, or -1
  std::size_t n_breaks_seen_ = 0;
};

}  // namespace crackle::fracture
