// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/release.h"
#include "input/model.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace crackle::fracture {

/// A saw-tooth softening law (Rots, Sequentially linear continuum model for concrete fracture, 2001): the
/// stiffness of a tetrahedron falls in steps, so that its stress peaks follow a linear or exponential curve
/// of stress over opening.
///
/// All quantities are relative to the state at which the strength is reached: thresholds are stresses of the
/// intact material at the same strain, in units of the strength, hence multiples of the strain at first
/// softening; dissipated energies are relative to the strain energy at first softening. The peaks are 1, 1 -
/// 1/n, ..., 1/n of the strength. The curve is stretched so that the steps dissipate exactly the prescribed
/// energy.
class SofteningLaw {
public:
  struct Tooth {
    double share;      ///< of the stiffness, until this tooth falls
    double threshold;  ///< at which it falls
  };

  /// @param n_teeth at least 2
  SofteningLaw(input::SofteningCurve curve, int n_teeth);

  /// The teeth of a tetrahedron, with shares decreasing and thresholds increasing from 1.
  /// @param ductility dissipated energy over the strain energy at first softening. At 1 or less the
  ///   tetrahedron breaks at once, as softening would dissipate more energy than available.
  std::vector<Tooth> teeth(double ductility) const;

private:
  std::vector<Tooth> curve(double stretch) const;

  input::SofteningCurve curve_;
  int n_teeth_;
};

/// Softening: a tetrahedron loses its stiffness tooth by tooth before it breaks.
class Softening final : public Release {
public:
  /// @param dissipation of each local tetrahedron, per volume [J/m^3]
  Softening(const SofteningLaw& law, std::vector<double> dissipation, Course course = {})
      : Release(std::move(course)), law_(law), dissipation_(std::move(dissipation)) {}

  bool softens() const override { return true; }
  std::optional<Reduction> reduce(std::int32_t tetrahedron, double energy) override;
  void restore(std::int32_t tetrahedron, double ductility) override;
  double threshold(std::int32_t tetrahedron) const override;

private:
  struct Softened {
    int n_fallen = 0;
    double ductility = 0;
  };

  SofteningLaw law_;
  std::vector<double> dissipation_;
  std::unordered_map<std::int32_t, Softened> softened_;
};

/// Energy dissipated by the teeth under proportional strain, relative to the energy at first softening.
double dissipation(const std::vector<SofteningLaw::Tooth>& teeth);

}  // namespace crackle::fracture
