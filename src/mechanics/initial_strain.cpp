// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/initial_strain.h"

#include "common/real.h"

#include <algorithm>
#include <utility>

namespace crackle::mechanics {

namespace {

void add(double factor, const std::vector<Symmetric>& strain, std::vector<Symmetric>& sum) {
  if (factor == 0) return;
  for (std::size_t t = 0; t < sum.size(); ++t)
    for (std::size_t i = 0; i < sum[t].size(); ++i) sum[t][i] += factor * strain[t][i];
}

}  // namespace

InitialStrain::InitialStrain(std::vector<Part> parts, std::int32_t n_tetrahedra)
    : parts_(std::move(parts)), now_(index(n_tetrahedra)), rate_(index(n_tetrahedra)) {
  set_time(0);
}

void InitialStrain::set_time(double time) {
  time_ = time;
  std::ranges::fill(now_, Symmetric{});
  std::ranges::fill(rate_, Symmetric{});
  for (const Part& part : parts_) {
    add(part.factor.at(time), part.strain, now_);
    add(part.factor.slope(time), part.strain, rate_);
  }
}

}  // namespace crackle::mechanics
