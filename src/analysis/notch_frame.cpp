// SPDX-License-Identifier: GPL-3.0-or-later
#include "notch_frame.h"

namespace crackle::analysis {

NotchFrame notch_frame(const geometry::Body& body, int notch) {
  using input::Face;
  const input::Notch& slot = body.notch(notch);
  const bool on_y_face = slot.face == Face::y_min || slot.face == Face::y_max;
  const bool on_lower_face = slot.face == Face::y_min || slot.face == Face::z_min;
  NotchFrame frame{};
  frame.axis = on_y_face ? 1 : 2;
  frame.across = on_y_face ? 2 : 1;
  const double length = body.size()[static_cast<std::size_t>(frame.axis)];
  frame.tip = on_lower_face ? slot.depth : length - slot.depth;
  frame.direction = on_lower_face ? 1 : -1;
  frame.ligament = length - slot.depth;
  return frame;
}

}  // namespace crackle::analysis
