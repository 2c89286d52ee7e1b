#include "model/processor/instruction_set.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <stdexcept>
#include <string>

#include "model/processor/kernels.h"

namespace tribotrack::model::internal {

namespace {

std::atomic<InstructionSet>& in_use() {
  static std::atomic<InstructionSet> set = available_instruction_sets().back();
  return set;
}

}  // namespace

const char* to_string(InstructionSet set) {
  return std::array{"baseline", "AVX2", "AVX-512"}.at(static_cast<std::size_t>(set));
}

std::vector<InstructionSet> available_instruction_sets() {
  std::vector<InstructionSet> sets{InstructionSet::baseline};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    sets.push_back(InstructionSet::avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
      sets.push_back(InstructionSet::avx512);
  }
#endif
  return sets;
}

InstructionSet instruction_set() {
  return in_use();
}

void use_instruction_set(InstructionSet set) {
  const auto sets = available_instruction_sets();
  if (std::find(sets.begin(), sets.end(), set) == sets.end())
    throw std::invalid_argument(std::string("this processor has no ") + to_string(set));
  in_use() = set;
}

Kernels kernels() {
#if defined(__x86_64__)
  if (instruction_set() == InstructionSet::avx512) return kernels_avx512();
  if (instruction_set() == InstructionSet::avx2) return kernels_avx2();
#endif
  return kernels_baseline();
}

}  // namespace tribotrack::model::internal
