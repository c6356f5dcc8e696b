// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/softening.h"

#include "crackle/common/index.h"

#include <cmath>

namespace crackle::fracture {

SofteningLaw::SofteningLaw(input::SofteningCurve curve, int n_teeth) : curve_(curve), n_teeth_(n_teeth) {}

/// The opening d at which the stress is 1 - k / n is `stretch` times k / n, or stretch times -ln(1 - k / n).
std::vector<SofteningLaw::Tooth> SofteningLaw::curve(double stretch) const {
  std::vector<Tooth> teeth;
  teeth.reserve(index(n_teeth_));
  for (int k = 0; k < n_teeth_; ++k) {
    const double fallen = static_cast<double>(k) / n_teeth_;
    const double stress = 1 - fallen;
    const double opening = stretch * (curve_ == input::SofteningCurve::linear ? fallen : -std::log(stress));
    // Logarithms may differ between processors in the last bit, so round.
    const double threshold = std::ldexp(std::rint(std::ldexp(stress + opening, 40)), -40);
    teeth.push_back({stress / threshold, threshold});
  }
  return teeth;
}

std::vector<SofteningLaw::Tooth> SofteningLaw::teeth(double ductility) const {
  const double least = 1;  // smallest stretch for which the strain does not decrease with the stress
  if (!(ductility > dissipation(curve(least)))) return {{1, 1}};
  double lower = least, upper = 2 * least;
  while (dissipation(curve(upper)) < ductility) upper *= 2;
  for (;;) {
    const double middle = 0.5 * (lower + upper);
    if (middle <= lower || middle >= upper) return curve(upper);
    (dissipation(curve(middle)) < ductility ? lower : upper) = middle;
  }
}

double dissipation(const std::vector<SofteningLaw::Tooth>& teeth) {
  double sum = 0;
  for (std::size_t k = 0; k < teeth.size(); ++k) {
    const double next = k + 1 < teeth.size() ? teeth[k + 1].share : 0;
    sum += (teeth[k].share - next) * teeth[k].threshold * teeth[k].threshold;
  }
  return sum;
}

}  // namespace crackle::fracture
