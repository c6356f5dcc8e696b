// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "document.h"
#include "input/reader.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace crackle::input {

/// The document with other values. Missing keys are added, with the tables around them.
/// @throws InputError when a value cannot be placed
Value with_settings(Value root, const std::vector<Setting>& settings);

/// First and last byte offset of a value in its text.
std::pair<std::size_t, std::size_t> extent_of(const std::string& text, const Value& value);

/// The text without its tables [[name]]. @throws InputError when they are written in another form
std::string without_tables(const std::string& text, const std::string& name);

}  // namespace crackle::input
