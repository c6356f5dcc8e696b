// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/instruction_set.h"

#include "common/index.h"

#include <array>

namespace crackle {

std::vector<InstructionSet> available_instruction_sets() {
  std::vector<InstructionSet> sets{InstructionSet::generic};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) {
    sets.push_back(InstructionSet::avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")) {
      sets.push_back(InstructionSet::avx512);
    }
  }
#endif
  return sets;
}

InstructionSet best_instruction_set() {
  static const InstructionSet best = available_instruction_sets().back();
  return best;
}

std::string_view to_string(InstructionSet set) {
  constexpr std::array names{"generic", "AVX2", "AVX-512"};
  return names.at(index(set));
}

}  // namespace crackle
