#include "model/arcs/arc.h"

#include "model/processor/instruction_set.h"

namespace tribotrack::model::internal {

ArcSolvers arc_solvers_baseline();
#if defined(__x86_64__)
ArcSolvers arc_solvers_avx2();
ArcSolvers arc_solvers_avx512();
#endif

ArcSolvers arc_solvers() {
#if defined(__x86_64__)
  switch (instruction_set()) {
    case InstructionSet::avx512:
      return arc_solvers_avx512();
    case InstructionSet::avx2:
      return arc_solvers_avx2();
    case InstructionSet::baseline:
      break;
  }
#endif
  return arc_solvers_baseline();
}

}  // namespace tribotrack::model::internal
