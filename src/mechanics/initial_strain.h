// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "mechanics/load_curve.h"
#include "mechanics/tensor.h"

#include <cstdint>
#include <vector>

namespace crackle::mechanics {

/// The strain at which each local tetrahedron is free of stress: a sum of fields, each times a function of
/// time. The stress is that of the elastic strain, the strain of the displacement less this one (Mura,
/// Micromechanics of defects in solids, 1987: an eigenstrain).
class InitialStrain {
public:
  struct Part {
    LoadCurve factor;
    std::vector<Symmetric> strain;  ///< of each local tetrahedron, at factor 1
  };

  InitialStrain() = default;  ///< none
  /// At time 0. @param n_tetrahedra of the subdomain
  InitialStrain(std::vector<Part> parts, std::int32_t n_tetrahedra);

  bool is_none() const { return parts_.empty(); }
  const std::vector<Part>& parts() const { return parts_; }

  void set_time(double time);
  double time() const { return time_; }

  /// Now. @pre not is_none()
  const Symmetric& operator[](std::int32_t tetrahedron) const { return now_[index(tetrahedron)]; }
  /// Elastic part of a strain, now.
  Symmetric elastic(std::int32_t tetrahedron, const Symmetric& strain) const {
    return is_none() ? strain : difference(strain, now_[index(tetrahedron)]);
  }
  /// Elastic part of a strain rate, from now on [1/s].
  Symmetric elastic_rate(std::int32_t tetrahedron, const Symmetric& rate) const {
    return is_none() ? rate : difference(rate, rate_[index(tetrahedron)]);
  }

private:
  static Symmetric difference(const Symmetric& a, const Symmetric& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]};
  }

  std::vector<Part> parts_;
  double time_ = 0;
  std::vector<Symmetric> now_, rate_;  // of each local tetrahedron
};

}  // namespace crackle::mechanics
