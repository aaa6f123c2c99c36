// The instruction sets for which functions of packs are compiled (see pack.hpp); all give the same bits.
#pragma once

namespace quern {

enum class InstructionSet { portable, avx2, avx512 };

// Whether this processor has it.
inline bool supports(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("popcnt");
  if (set == InstructionSet::avx2) return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt");
#endif
  return set == InstructionSet::portable;
}

inline InstructionSet best_instruction_set() {
  for (const InstructionSet set : {InstructionSet::avx512, InstructionSet::avx2})
    if (supports(set)) return set;
  return InstructionSet::portable;
}

}  // namespace quern
