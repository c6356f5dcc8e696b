// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace crackle::input {

/// The text without its tables [[name]]. @throws InputError when they are written in another form
std::string without_tables(const std::string& text, const std::string& name);

}  // namespace crackle::input
