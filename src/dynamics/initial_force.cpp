// SPDX-License-Identifier: GPL-3.0-or-later
#include "initial_force.h"

#include "crackle/common/index.h"

#include <algorithm>

namespace crackle::dynamics {

InitialForce::InitialForce(const fracture::BreakableBody& body) : body_(&body) {
  if (body.initial_strain().is_none()) return;
  around_ = mechanics::node_tetrahedra(body.subdomain());
  const std::int32_t n_owned = body.subdomain().layout.n_owned;
  force_.resize(3 * index(n_owned));
  for (std::int32_t node = 0; node < n_owned; ++node) sum_at(node);
}

std::span<const std::int32_t> InitialForce::update(std::span<const std::int32_t> tetrahedra) {
  changed_.clear();
  if (is_none()) return changed_;
  for (const auto t : tetrahedra)
    for (const auto node : body_->subdomain().tetrahedra[index(t)])
      if (node < body_->subdomain().layout.n_owned) changed_.push_back(node);
  std::ranges::sort(changed_);
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  for (const auto node : changed_) sum_at(node);
  return changed_;
}

void InitialForce::sum_at(std::int32_t node) {
  Vector sum{};
  for (const auto number : around_[node]) {
    if (!body_->residual_stiffness().carries(number)) continue;
    const auto& t = body_->operators().tetrahedra[index(number)];
    const auto corner = static_cast<std::size_t>(std::ranges::find(t.nodes, node) - t.nodes.begin());
    const auto sigma = body_->residual_stiffness().stress(number, body_->initial_strain()[number]);
    sum = sum + t.volume * mechanics::apply(sigma, t.gradient[corner]);
  }
  for (int c = 0; c < 3; ++c) force_[index(node, c)] = sum[index(c)];
}

}  // namespace crackle::dynamics
