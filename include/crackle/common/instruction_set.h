// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

namespace crackle {

/// Which vector instructions the hot loops use; the results are the same bits.
enum class InstructionSet { generic, avx2, avx512 };

/// What this machine has, from `generic` to the best.
std::vector<InstructionSet> available_instruction_sets();
InstructionSet best_instruction_set();
std::string_view to_string(InstructionSet set);

}  // namespace crackle
