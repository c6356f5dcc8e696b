// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/criterion.h"

#include "crackle/fracture/tuler_butcher.h"

namespace crackle::fracture {

std::unique_ptr<Criterion> make_criterion(const input::Parameters& parameters, std::vector<double> strengths,
                                          double time_step, mechanics::TetrahedronField<double> impulses) {
  const input::Fracture fracture = parameters.fracture_of(0);
  if (fracture.accumulation == input::Accumulation::step)
    return std::make_unique<OneStepTulerButcher>(fracture, impulses, std::move(strengths), time_step);
  return std::make_unique<TulerButcher>(fracture, std::move(impulses), std::move(strengths), time_step);
}

}  // namespace crackle::fracture
