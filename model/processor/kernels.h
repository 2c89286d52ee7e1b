// The kernels that are compiled once for each instruction set, and chosen at run time.
#pragma once

#include "model/arcs/arc.h"
#include "model/rivals/rival_step.h"

namespace tribotrack::model::internal {

struct Kernels {
  ArcSolvers arcs;
  RivalStepper rival_step = nullptr;
};

Kernels kernels();  ///< in the instruction set in use (instruction_set.h)

Kernels kernels_baseline();
Kernels kernels_avx2();
Kernels kernels_avx512();

}  // namespace tribotrack::model::internal
