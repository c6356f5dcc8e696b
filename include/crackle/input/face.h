// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"

#include <array>
#include <cstddef>

namespace crackle::input {

/// A face of the specimen's box; x is the thickness, y the width, z the length.
enum class Face : int { x_min, x_max, y_min, y_max, z_min, z_max };

inline constexpr std::array face_names{"x-min", "x-max", "y-min", "y-max", "z-min", "z-max"};

constexpr const char* name_of(Face face) {
  return face_names[index(face)];
}

/// Axis of the normal: 0, 1 or 2.
constexpr int axis_of(Face face) {
  return static_cast<int>(face) / 2;
}

/// Whether it is the face at the upper end of its axis.
constexpr bool is_upper(Face face) {
  return static_cast<int>(face) % 2 == 1;
}

/// The axis in the y-z plane along which the position of a notch in this face is given.
constexpr int position_axis(Face face) {
  return axis_of(face) == 1 ? 2 : 1;
}

}  // namespace crackle::input
