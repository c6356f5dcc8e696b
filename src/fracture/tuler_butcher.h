// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "fracture/criterion.h"

namespace crackle::fracture {

/// The Tuler-Butcher criterion (paper eq. 5): a tetrahedron breaks when the integral of (sigma_1 -
/// sigma_0)^beta over the time with sigma_1 > sigma_0 reaches K_f. Its memory is the current value of the
/// integral.
class TulerButcher final : public Criterion {
public:
  /// @param impulses K_f of each tetrahedron [Pa^beta s]
  /// @param strengths sigma_0 of each tetrahedron [Pa]
  /// @param time_step with which advance() will be called [s]
  TulerButcher(const input::Fracture& parameters, mechanics::TetrahedronField<double> impulses,
               std::vector<double> strengths, double time_step);

  /// A tetrahedron below its strength may exceed it and break within half a step.
  double screening_share(double stable_step) const override;

protected:
  /// The stress is assumed to vary linearly within the step.
  ///
  /// A tetrahedron can break only at the end of a step. It does so at the one closest to the time at which
  /// the integral reaches K_f: at most half a step too early or too late, and unbiased on average. The stress
  /// within the next half step is extrapolated by the parabola through its last three values.
  bool integrate(std::size_t tetrahedron, double earlier, double before, double after) override;
  double delay(std::size_t tetrahedron, double stress) const override;

private:
  double mean_rate(double from, double to) const;

  double exponent_;
  mechanics::TetrahedronField<double> impulses_;  // K_f
  double time_step_;
};

/// The paper's "tau_f is the time step" (`accumulation = "step"`): the integral covers the last step only. A
/// tetrahedron then breaks at once if sigma_1 exceeds sigma_0 + (K_f / step)^(1 / beta), and never below,
/// however slowly it is loaded: this is its strength. A strength derived from a toughness is that limit
/// itself.
class OneStepTulerButcher final : public Criterion {
public:
  /// @copydoc TulerButcher::TulerButcher
  OneStepTulerButcher(const input::Fracture& parameters, const mechanics::TetrahedronField<double>& impulses,
                      std::vector<double> strengths, double time_step);

protected:
  bool integrate(std::size_t tetrahedron, double, double, double after) override {
    return after > strengths_[tetrahedron];
  }
  double delay(std::size_t, double) const override { return time_step_; }

private:
  double time_step_;
};

}  // namespace crackle::fracture
