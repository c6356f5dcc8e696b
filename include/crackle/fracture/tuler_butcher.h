// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/fracture/criterion.h"

namespace crackle::fracture {

/// The Tuler-Butcher criterion (paper eq. 5): a tetrahedron breaks when the integral of
/// (sigma_1 - sigma_0)^beta over the time with sigma_1 > sigma_0 reaches K_f. Its memory is the integral so
/// far.
class TulerButcher final : public Criterion {
public:
  /// @param strengths sigma_0 of each tetrahedron [Pa]
  /// @param time_step that advance() will be called with [s]
  TulerButcher(const input::Fracture& parameters, std::vector<double> strengths, double time_step);

  /// One that is below its strength may be about to pass it and to break within half a step.
  double screening_share(double stable_step) const override;

protected:
  /// The stress is taken to change in proportion to time within the step.
  ///
  /// A tetrahedron can break at the end of a step only. It does so at the end that is nearest to the moment
  /// at which the integral reaches K_f: half a step too early or too late at most, and neither on average.
  /// What the stress comes to within the next half step is foreseen by the parabola through its last three
  /// values.
  bool integrate(std::size_t tetrahedron, double earlier, double before, double after) override;
  double delay(std::size_t tetrahedron, double stress) const override;

private:
  double mean_rate(double from, double to) const;

  double exponent_;
  double impulse_;  // K_f
  double time_step_;
};

/// The paper's "tau_f is the time step" (`memory = "step"`): only the last step counts in the integral. A
/// tetrahedron then breaks at once where sigma_1 exceeds sigma_0 + (K_f / step)^(1 / beta), and never below,
/// however slowly it is loaded: this is its strength. One that follows from a toughness is that limit itself.
class OneStepTulerButcher final : public Criterion {
public:
  /// @copydoc TulerButcher::TulerButcher
  OneStepTulerButcher(const input::Fracture& parameters, std::vector<double> strengths, double time_step);

protected:
  bool integrate(std::size_t tetrahedron, double, double, double after) override {
    return after > strengths_[tetrahedron];
  }
  double delay(std::size_t, double) const override { return time_step_; }

private:
  double time_step_;
};

}  // namespace crackle::fracture
