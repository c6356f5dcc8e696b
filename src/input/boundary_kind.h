// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace crackle::input {

/// The quantity prescribed by a boundary condition.
enum class BoundaryKind {
  fix,           ///< zero displacement of the chosen components
  force,         ///< total force, distributed by area [N]
  traction,      ///< [Pa]
  velocity,      ///< [m/s]
  displacement,  ///< [m]
  pressure,      ///< against the outward normal, in value[0] [Pa]
  absorbing,     ///< nothing: waves leave the body
};

/// How a condition acts on the body.
enum class Action { load, motion, dashpots };
/// How its quantity is given.
enum class QuantityForm { none, scalar, vector };

/// Properties of a kind of boundary condition, apart from the texts of its key
/// (src/input/boundary_keys.cpp), its dimensions (src/input/dimension.cpp) and the loads that it makes
/// (src/mechanics/condition_loads.cpp).
struct BoundaryTraits {
  BoundaryKind kind;
  const char* name;  ///< key of [[boundary]]
  Action action;
  QuantityForm form;
  bool by_area;  ///< acts per area, so that its region may not be a line or a point
};

/// All kinds, in the order of the enumeration.
inline constexpr std::array boundary_kinds{
    BoundaryTraits{BoundaryKind::fix, "fix", Action::motion, QuantityForm::none, false},
    BoundaryTraits{BoundaryKind::force, "force", Action::load, QuantityForm::vector, false},
    BoundaryTraits{BoundaryKind::traction, "traction", Action::load, QuantityForm::vector, true},
    BoundaryTraits{BoundaryKind::velocity, "velocity", Action::motion, QuantityForm::vector, false},
    BoundaryTraits{BoundaryKind::displacement, "displacement", Action::motion, QuantityForm::vector, false},
    BoundaryTraits{BoundaryKind::pressure, "pressure", Action::load, QuantityForm::scalar, true},
    BoundaryTraits{BoundaryKind::absorbing, "absorbing", Action::dashpots, QuantityForm::none, true},
};

static_assert([] {
  for (std::size_t i = 0; i < boundary_kinds.size(); ++i)
    if (static_cast<std::size_t>(boundary_kinds[i].kind) != i) return false;
  return true;
}());

constexpr const BoundaryTraits& traits(BoundaryKind kind) {
  return boundary_kinds[index(kind)];
}

/// By BoundaryKind, as the keys of [[boundary]].
inline constexpr auto kind_names = [] {
  std::array<const char*, boundary_kinds.size()> names{};
  std::ranges::transform(boundary_kinds, names.begin(), &BoundaryTraits::name);
  return names;
}();

constexpr const char* name_of(BoundaryKind kind) {
  return traits(kind).name;
}

constexpr bool prescribes_motion(BoundaryKind kind) {
  return traits(kind).action == Action::motion;
}

/// True if a quantity is prescribed, which may change with time.
constexpr bool has_quantity(BoundaryKind kind) {
  return traits(kind).form != QuantityForm::none;
}

}  // namespace crackle::input
