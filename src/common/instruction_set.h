// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

namespace crackle {

/// Vector instructions used by the hot loops; the results are bitwise equal.
enum class InstructionSet { generic, avx2, avx512 };

/// Those supported by this machine, from `generic` to the best.
std::vector<InstructionSet> available_instruction_sets();
InstructionSet best_instruction_set();
std::string_view to_string(InstructionSet set);

}  // namespace crackle
