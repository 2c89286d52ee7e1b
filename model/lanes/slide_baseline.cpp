// The steps of sliding lanes for any processor.
#include "model/lanes/slide_kernel.h"

namespace tribotrack::model::internal {

namespace {
struct Here;  // makes every function of the kernel this file's own
}

SlideMachines slide_machines_baseline() {
  return SlideKernel<Here, 4>::machines();
}

}  // namespace tribotrack::model::internal
