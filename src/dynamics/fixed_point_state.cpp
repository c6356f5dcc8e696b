// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixed_point_state.h"

#include <stdexcept>

namespace crackle::dynamics {

template <class Real>
FixedPointState<Real>::FixedPointState(const geometry::Subdomain& subdomain,
                                       const mechanics::FixedPointScale& scale,
                                       std::span<kernels::NodeRecord<Real>> nodes, const MotionState& start)
    : subdomain_(&subdomain),
      scale_(scale),
      nodes_(nodes),
      velocity_(static_cast<std::size_t>(subdomain.layout.n_owned)),
      whole_(nodes.size()) {
  for (std::size_t i = 0; i < 3 * nodes_.size(); ++i) {
    whole_[i / 3][i % 3] =
        quantized<std::int64_t>(start.displacement.local()[i], scale_.displacement, starts_in_range_);
    nodes_[i / 3].displacement[i % 3] = low_digits<Real>(whole_[i / 3][i % 3]);
  }
  for (std::size_t i = 0; i < 3 * velocity_.size(); ++i)
    velocity_[i / 3].value[i % 3] =
        quantized<Integer>(start.velocity.owned()[i], scale_.velocity, starts_in_range_);
  before_[0].resize(nodes_.size());
  keep_displacements(0, nodes_.size());
  before_[1] = before_[0];
}

template <class Real>
void FixedPointState<Real>::unwrap() {
  for (std::size_t n = 0; n < whole_.size(); ++n)
    for (std::size_t c = 0; c < 3; ++c) whole_[n][c] = whole_displacement(n, c);
}

template <class Real>
void FixedPointState<Real>::read(MotionState& state) const {
  const auto u = state.displacement.local();
  for (std::size_t n = 0; n < nodes_.size(); ++n)
    for (std::size_t c = 0; c < 3; ++c)
      u[3 * n + c] = scale_.displacement * static_cast<double>(whole_displacement(n, c));
  const auto v = state.velocity.owned();
  for (std::size_t n = 0; n < velocity_.size(); ++n)
    for (std::size_t c = 0; c < 3; ++c)
      v[3 * n + c] = scale_.velocity * static_cast<double>(velocity_[n].value[c]);
}

template <class Real>
parallel::NumberedRows FixedPointState<Real>::rows(bool with_force) const {
  parallel::NumberedRows rows;
  rows.width = with_force ? 12 : 9;
  for (std::size_t n = 0; n < velocity_.size(); ++n) {
    rows.numbers.push_back(subdomain_->layout.number[n]);
    for (std::size_t c = 0; c < 3; ++c) rows.values.push_back(whole_displacement(n, c));
    for (std::size_t c = 0; c < 3; ++c) rows.values.push_back(velocity_[n].value[c]);
    for (std::size_t c = 0; c < 3; ++c) rows.values.push_back(before_[0][n][c]);
    for (std::size_t c = 0; c < 3 && with_force; ++c) rows.values.push_back(nodes_[n].force[c]);
  }
  return rows;
}

template <class Real>
void FixedPointState<Real>::restore(const parallel::NumberedRows& rows, bool with_force) {
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const auto row = rows.find(subdomain_->layout.number[n]);
    if (row.empty()) throw std::runtime_error("the checkpoint belongs to another mesh");
    for (std::size_t c = 0; c < 3; ++c) {
      whole_[n][c] = row[c];
      nodes_[n].displacement[c] = low_digits<Real>(row[c]);
      before_[0][n][c] = static_cast<Integer>(row[6 + c]);
      if (n >= velocity_.size()) continue;
      velocity_[n].value[c] = static_cast<Integer>(row[3 + c]);
      if (with_force) nodes_[n].force[c] = static_cast<Integer>(row[9 + c]);
    }
  }
}

template class FixedPointState<float>;
template class FixedPointState<double>;

}  // namespace crackle::dynamics
