// The kernels for processors with AVX-512.
#include "model/processor/kernels.h"

#include "model/arcs/arc_kernel.h"
#include "model/rivals/rival_step.h"

namespace tribotrack::model::internal {

namespace {
struct Here;  // makes every function of the kernels this file's own
}

Kernels kernels_avx512() {
  return {{ArcKernel<Here, 4>::solve, ArcKernel<Here, 8>::solve}, RivalStep<Here>::take};
}

}  // namespace tribotrack::model::internal
