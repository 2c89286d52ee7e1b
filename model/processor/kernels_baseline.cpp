// The kernels of arcs for any processor.
#include "model/processor/kernels.h"

#include "model/arcs/arc_kernel.h"

namespace tribotrack::model::internal {

namespace {
struct Here;  // makes every function of the kernels this file's own
}

ArcSolvers kernels_baseline() {
  return {ArcKernel<Here, 4>::solve, ArcKernel<Here, 8>::solve};
}

}  // namespace tribotrack::model::internal
