// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "document.h"
#include "findings.h"

namespace crackle::input {

/// Reports every key and table of the document that the schema does not have, with the nearest known name,
/// and tables that stand in the wrong form ([name] for [[name]], a number for a table).
void report_unknown_keys(const Value& root, Findings& findings);

}  // namespace crackle::input
