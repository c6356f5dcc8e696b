// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/softening.h"

#include "common/index.h"

#include <algorithm>
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

std::optional<Release::Reduction> Softening::reduce(std::int32_t tetrahedron, double energy) {
  auto& softened = softened_[tetrahedron];
  if (softened.n_fallen == 0) softened.ductility = dissipation_[index(tetrahedron)] / energy;
  const auto teeth = law_.teeth(softened.ductility);
  ++softened.n_fallen;
  if (softened.n_fallen == std::ssize(teeth)) return {};
  return Reduction{teeth[index(softened.n_fallen)].share, softened.ductility};
}

void Softening::restore(std::int32_t tetrahedron, double ductility) {
  auto& softened = softened_[tetrahedron];
  ++softened.n_fallen;
  softened.ductility = ductility;
}

double Softening::threshold(std::int32_t tetrahedron) const {
  const auto softened = softened_.find(tetrahedron);
  if (softened == softened_.end()) return 1;
  const auto teeth = law_.teeth(softened->second.ductility);
  return teeth[std::min(index(softened->second.n_fallen), teeth.size() - 1)].threshold;
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
