// The steps of sliding lanes for processors with AVX-512.
#include "model/lanes/slide_kernel.h"

namespace tribotrack::model::internal {

namespace {
struct Here;  // makes every function of the kernel this file's own
}

SlideMachines slide_machines_avx512() {
  return SlideKernel<Here, 8>::machines();
}

}  // namespace tribotrack::model::internal
