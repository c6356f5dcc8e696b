// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/complex.h"

#include <memory>

namespace crackle::geometry {

/// The body of a file. No places where cracks start are known, and it has no outline.
Complex solid_complex(const std::shared_ptr<const solid::Solid>& solid);

}  // namespace crackle::geometry
