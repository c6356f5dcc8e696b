// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/vector.h"

#include <array>
#include <cstdint>

namespace crackle::geometry {

using Point = Vector;  ///< [m]
using Tetrahedron = std::array<std::int32_t, 4>;
using Triangle = std::array<std::int32_t, 3>;

}  // namespace crackle::geometry
