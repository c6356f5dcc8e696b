// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"

namespace crackle::input {

void check_availability(const Parameters& parameters, Findings& findings) {
  if (parameters.fracture.release == Release::facet) {
    findings.report("fracture.release", "\"facet\" is not available in this version; give \"element\"");
  }
}

}  // namespace crackle::input
