// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/parameters.h"

#include <array>
#include <string>
#include <vector>

namespace crackle::input {

/// A unit for display.
struct ReadableUnit {
  std::string name;
  double factor;    ///< SI value of one unit
  double from = 0;  ///< smallest SI value displayed in this unit; 0: one unit
};

/// The physical dimension of a value.
struct Dimension {
  std::string name;                 ///< with its article: "a length"
  std::string si_unit;              ///< as UDUNITS reads it: "m"
  std::string example;              ///< "1.0 mm"
  double exponent = 0;              ///< beta of stress^beta time; 0 otherwise
  std::vector<ReadableUnit> units;  ///< largest first
  /// The square of the SI unit, for a unit with a root, which UDUNITS cannot read; otherwise empty.
  std::string square = {};
};

extern const Dimension length_dimension, time_dimension, stress_dimension, density_dimension,
    energy_per_area_dimension, volume_dimension, rate_of_decay_dimension, stress_intensity_dimension,
    angle_dimension, temperature_dimension, expansion_dimension, acceleration_dimension,
    acceleration_rate_dimension, body_force_dimension, body_force_rate_dimension, angular_velocity_dimension,
    velocity_gradient_dimension, number_density_dimension, mass_dimension, share_dimension;

/// stress^exponent time, the dimension of the Tuler-Butcher impulse K_f.
Dimension impulse_dimension(double exponent);

inline constexpr std::array axis_names{"x", "y", "z"};

/// The dimensions of the quantity prescribed by a boundary condition, and of its rate of change.
/// @pre has_quantity(kind)
const Dimension& value_dimension(BoundaryKind kind);
const Dimension& rate_dimension(BoundaryKind kind);

/// All dimensions of input keys; with a non-zero exponent, including that of the impulse.
std::vector<Dimension> known_dimensions(double exponent);

/// The dimension with another example for messages.
Dimension with_example(Dimension dimension, std::string example);

/// "24.5 mm": the value in the largest readable unit that fits it.
std::string format_quantity(double value, const Dimension& dimension);

/// "24.5 mm": a length.
std::string show(double length);

/// The same in a message, where 0 stands beside millimetres. (Digests are taken of the echo, which has "0
/// m".)
std::string shown_length(double length);

/// A dimensionless number, with at most ten digits.
std::string format_number(double value);

}  // namespace crackle::input
