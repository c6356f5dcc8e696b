// SPDX-License-Identifier: GPL-3.0-or-later
#include "initial_velocity.h"

#include "crackle/common/index.h"

namespace crackle::dynamics {

void set_initial_velocity(const MotionContext& context, const input::Parameters& parameters,
                          MotionState& state) {
  const auto v = state.velocity.owned();
  const auto& nodes = context.body->subdomain().nodes;
  for (const input::BodyLoad& load : parameters.initial_velocities())
    for (std::size_t n = 0; 3 * n < v.size(); ++n) {
      const Vector velocity = load.at(nodes[n]);
      for (std::size_t c = 0; c < 3; ++c) v[3 * n + c] += velocity[c];
    }
  for (const auto& motion : context.loads->motions)
    for (const auto node : motion.nodes) v[index(node, motion.component)] = 0;
}

}  // namespace crackle::dynamics
