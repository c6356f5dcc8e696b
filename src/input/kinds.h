// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "schema.h"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Tables that prescribe exactly one of several kinds, most of them by three components: [[boundary]] and
/// [[load]].
namespace crackle::input {

/// Accepts a table without the key, since another of the kinds is given.
Requirement one_of_kinds(std::span<const char* const> kinds);

/// The kinds that the file gives in a table; there should be one.
std::vector<std::string> kinds_given(const Findings& findings, const std::string& table,
                                     std::span<const char* const> kinds);

/// Reports a table with no kind, or with several.
/// @param name of the table, such as "boundary"
void check_kind(const std::string& table, const char* name, std::span<const char* const> kinds,
                Findings& findings);

struct Components {
  Vector value{};
  std::array<bool, 3> prescribed{};  ///< false: "free"
};

/// @param may_be_free accepts "free" in place of a quantity
std::string components_form(const Dimension& dimension, bool may_be_free = false);
std::optional<Components> read_components(const Source& source, const Dimension& dimension,
                                          const Range& range, bool may_be_free = false);
/// Like read_quantity, but UDUNITS would take "50 Hz" for 50 rad/s: the unit must name an angle.
std::optional<double> read_angular_velocity(const Source& source);
std::string show_components(const Vector& value, const Dimension& dimension,
                            const std::array<bool, 3>& prescribed = {true, true, true});

}  // namespace crackle::input
