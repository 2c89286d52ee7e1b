// The kernels of arcs and of sliding lanes for processors with AVX-512.
#include "model/processor/kernels.h"

#include "model/arcs/arc_kernel.h"
#include "model/lanes/slide_kernel.h"

namespace tribotrack::model::internal {

namespace {
struct Here;  // makes every function of the kernels this file's own
}

Kernels kernels_avx512() {
  return {{ArcKernel<Here, 4>::solve, ArcKernel<Here, 8>::solve}, SlideKernel<Here, 8>::machines()};
}

}  // namespace tribotrack::model::internal
