// The same campaign with fewer points, for models whose integration is slow.
#pragma once

#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

/// Tracks of at most some hundred points each (every k-th of them), the platform's phases taken as they were
/// fitted, exposures as of no length; summary runs, priors, unknowns, and correlated errors as they are; no
/// scatter between points. Points that are left out take nothing from the rest but their share of the
/// precision.
class Thinned {
 public:
  Thinned(const Residuals& residuals, const Minimum& best);
  Thinned(const Thinned&) = delete;
  Thinned& operator=(const Thinned&) = delete;

  const Residuals& residuals() const { return residuals_; }
  const Minimum& best() const { return best_; }  ///< of these points, from that of all

 private:
  Problem problem_;
  Unknowns unknowns_;
  Residuals residuals_;
  Minimum best_;
};

}  // namespace tribotrack::fit::internal
