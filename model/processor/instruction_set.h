// Which of the processor's vector instructions the numerical kernels use.
#pragma once

#include <vector>

namespace tribotrack::model::internal {

enum class InstructionSet { baseline, avx2, avx512 };

const char* to_string(InstructionSet set);

/// Those this processor has (and this build was compiled for), `baseline` first, the best last.
std::vector<InstructionSet> available_instruction_sets();

/// The one in use: the best available, unless `use_instruction_set` said otherwise. Results differ between
/// them by rounding only.
InstructionSet instruction_set();

/// For tests and benchmarks; not while other threads integrate. Throws std::invalid_argument if not
/// available.
void use_instruction_set(InstructionSet set);

}  // namespace tribotrack::model::internal
