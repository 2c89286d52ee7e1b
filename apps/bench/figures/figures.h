// The benchmarks' rows as figures.
#pragma once

#include <vector>

#include "apps/bench/fit/bench.h"
#include "apps/bench/fit/coverage.h"
#include "apps/bench/model/bench.h"
#include "apps/bench/scale/scale.h"
#include "apps/bench/vision/bench.h"
#include "apps/figures/figure.h"

namespace tribotrack::bench {

/// Error of the end point against CPU time, a panel for each scene.
apps::Figure model_figure(const std::vector<ModelBenchRow>& rows);

/// Rms error over the Cramer-Rao bound against CPU time per frame, a panel for each scene and radius, at
/// kDrawnNoise.
apps::Figure tracking_figure(const std::vector<VisionBenchRow>& rows);
inline constexpr double kDrawnNoise = 2;  ///< grey levels

/// What is estimated against CPU time per campaign: the error of mu1 and half its 95 % interval, and how far
/// from the minimum.
apps::Figure fit_error_figure(const std::vector<FitBenchRow>& rows);
apps::Figure fit_minimum_figure(const std::vector<FitBenchRow>& rows);

/// Which share of the 95 % intervals holds the truth, with its binomial 95 % range, against the nominal
/// share.
apps::Figure coverage_figure(const std::vector<CoverageRow>& rows);

/// CPU time, memory and file calls of whole commands against the size of their work, relative to the smallest
/// of each series: a panel for each cost.
apps::Figure scale_figure(const std::vector<ScaleRow>& rows);

}  // namespace tribotrack::bench
