#include "model/friction.h"

#include "model/equation/phase.h"

namespace tribotrack::model {

double Friction::coefficient(double wt) const {
  using internal::reduce;
  const double since_opening = reduce(reduce(wt).rest - reduce(phase).rest - reduce(lag).rest).rest;
  return since_opening < pulse_width ? reduced : nominal;
}

}  // namespace tribotrack::model
