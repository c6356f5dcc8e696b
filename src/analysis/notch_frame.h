// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"

namespace crackle::analysis {

/// A notch seen from its tip: the crack advances along `axis` across the ligament.
struct NotchFrame {
  int axis;          ///< 1 for a notch cut into a y-face, 2 for a z-face
  int across;        ///< the other axis in the plane of the plate
  double tip;        ///< position of the notch's tip along `axis` [m]
  double direction;  ///< +1 or -1: from the tip into the body
  double ligament;   ///< from the tip to the opposite face [m]

  double advance(double position) const { return direction * (position - tip); }
};

NotchFrame notch_frame(const geometry::Body& body, int notch);

}  // namespace crackle::analysis
