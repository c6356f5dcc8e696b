// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/criterion.h"

#include "crackle/fracture/tuler_butcher.h"

namespace crackle::fracture {

std::unique_ptr<Criterion> make_criterion(const input::Fracture& parameters, std::vector<double> strengths,
                                          double time_step) {
  if (parameters.memory == input::Memory::step)
    return std::make_unique<OneStepTulerButcher>(parameters, std::move(strengths), time_step);
  return std::make_unique<TulerButcher>(parameters, std::move(strengths), time_step);
}

std::unique_ptr<Criterion> make_criterion(const input::Fracture& parameters, std::size_t n_tetrahedra,
                                          double time_step) {
  return make_criterion(parameters, std::vector<double>(n_tetrahedra, parameters.strength), time_step);
}

}  // namespace crackle::fracture
