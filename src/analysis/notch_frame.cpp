// SPDX-License-Identifier: GPL-3.0-or-later
#include "notch_frame.h"

#include "crackle/common/index.h"

namespace crackle::analysis {

NotchFrame notch_frame(const geometry::Body& body, int notch) {
  const geometry::SlotSection& section = body.sections()[index(notch)];
  NotchFrame frame{};
  frame.axis = section.depth_axis;
  frame.across = section.at_axis;
  frame.tip = section.tip;
  frame.direction = section.mouth < section.tip ? 1 : -1;
  frame.ligament = body.size()[index(frame.axis)] - body.notch(notch).depth;
  return frame;
}

}  // namespace crackle::analysis
