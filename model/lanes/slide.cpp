#include "model/lanes/slide_lanes.h"
#include "model/processor/instruction_set.h"

namespace tribotrack::model::internal {

SlideMachines slide_machines_baseline();
#if defined(__x86_64__)
SlideMachines slide_machines_avx2();
SlideMachines slide_machines_avx512();
#endif

SlideMachines slide_machines() {
#if defined(__x86_64__)
  switch (instruction_set()) {
    case InstructionSet::avx512:
      return slide_machines_avx512();
    case InstructionSet::avx2:
      return slide_machines_avx2();
    case InstructionSet::baseline:
      break;
  }
#endif
  return slide_machines_baseline();
}

}  // namespace tribotrack::model::internal
