// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "fracture/breakable_body.h"
#include "mechanics/operators.h"
#include "mechanics/tensor.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::fracture {

/// Mean stresses around nodes: sum V sigma / sum V over the unbroken tetrahedra around a node.
///
/// Where the strain varies, the stresses of linear tetrahedra scatter by a tenth and more on any mesh, and
/// the most loaded of many break too early. The scatter cancels in these means, which converge to the stress
/// at the node (as the recovered stresses of Zienkiewicz and Zhu, Int. J. Numer. Methods Eng. 24, 1987). A
/// mean is taken over one material, or one interface: around a node between several there is one for each.
///
/// A mean can only exceed the strength if some tetrahedron around the node does, since the equivalent stress
/// is convex.
///
/// The rank that owns a node holds all tetrahedra around it; others do not know its means.
class NodalMeans {
public:
  /// @param body, round_node must outlive the object
  NodalMeans(const BreakableBody& body, const mechanics::NodeTetrahedra& round_node);

  std::int32_t n_patches() const { return n_patches_; }

  /// The number of the mean at a corner of a local tetrahedron, or -1 if another rank owns that node.
  std::int32_t patch(std::int32_t tetrahedron, std::size_t corner) const {
    if (!patches_.empty()) return patches_[index(tetrahedron)][corner];
    const std::int32_t node = body_->subdomain().tetrahedra[index(tetrahedron)][corner];
    return node < body_->subdomain().layout.n_owned ? node : -1;
  }

  /// The mean at a corner of an unbroken tetrahedron.
  /// @param stress of a local tetrahedron: a mechanics::Symmetric [Pa]
  /// @pre patch() is not -1
  template <class Stress>
  mechanics::Symmetric at(std::int32_t tetrahedron, std::size_t corner, const Stress& stress) const {
    const auto node = body_->subdomain().tetrahedra[index(tetrahedron)][corner];
    Sum sum;
    for (const auto t : (*round_node_)[node])
      if (!body_->is_broken(t) && kind(t) == kind(tetrahedron)) sum.add(volume(t), stress(t));
    return sum.mean();
  }

  /// The means of all patches; 0 where all is broken.
  /// @param stress as for at()
  template <class Stress>
  std::vector<mechanics::Symmetric> all(const Stress& stress) const {
    std::vector<Sum> sums(index(n_patches_));
    for (std::int32_t t = 0; t < body_->subdomain().n_tetrahedra(); ++t) {
      if (body_->is_broken(t)) continue;
      const mechanics::Symmetric sigma = stress(t);
      const double v = volume(t);
      for (std::size_t corner = 0; corner < 4; ++corner)
        if (const auto p = patch(t, corner); p >= 0) sums[index(p)].add(v, sigma);
    }
    std::vector<mechanics::Symmetric> means;
    means.reserve(sums.size());
    for (const Sum& sum : sums) means.push_back(sum.mean());
    return means;
  }

private:
  struct Sum {
    mechanics::Symmetric stress{};
    double volume = 0;

    void add(double v, const mechanics::Symmetric& sigma) {
      for (std::size_t i = 0; i < stress.size(); ++i) stress[i] += v * sigma[i];
      volume += v;
    }
    mechanics::Symmetric mean() const {
      mechanics::Symmetric result{};
      if (volume > 0)
        for (std::size_t i = 0; i < stress.size(); ++i) result[i] = stress[i] / volume;
      return result;
    }
  };

  double volume(std::int32_t tetrahedron) const {
    return body_->operators().tetrahedra[index(tetrahedron)].volume;
  }
  std::int32_t kind(std::int32_t tetrahedron) const { return body_->subdomain().kind(tetrahedron); }

  const BreakableBody* body_;
  const mechanics::NodeTetrahedra* round_node_;
  std::int32_t n_patches_;
  std::vector<std::array<std::int32_t, 4>> patches_;  // of each tetrahedron; empty: those of the nodes
};

}  // namespace crackle::fracture
