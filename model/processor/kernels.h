// The kernels that are compiled once for each instruction set, and chosen at run time.
#pragma once

#include "model/arcs/arc.h"

namespace tribotrack::model::internal {

ArcSolvers kernels();  ///< in the instruction set in use (instruction_set.h)

ArcSolvers kernels_baseline();
ArcSolvers kernels_avx2();
ArcSolvers kernels_avx512();

}  // namespace tribotrack::model::internal
