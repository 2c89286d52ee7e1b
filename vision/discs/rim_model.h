// The rim's model and its sums over pixels, the inner loops of fit_rim.
#pragma once

#include <vector>

#include "vision/discs/rim_fit.h"

namespace tribotrack::vision {

/// Of r = I - model with its slopes g: sum w g g^T, sum w r g, sum w r^2.
struct RimSums {
  RimCovariance normal;
  RimParameters gradient;
  double cost = 0;
};

RimSums rim_sums(const RimParameters& p, const RimPixels& pixels);

/// I - model at each pixel.
std::vector<double> rim_residuals(const RimParameters& p, const RimPixels& pixels);

/// w r (row . g) at each pixel.
std::vector<double> rim_pulls(const RimParameters& p, const RimPixels& pixels, const RimParameters& row);

/// Model and its slopes at one pixel.
double rim_model(const RimParameters& p, double x, double y, RimParameters& slope);

/// Phi and its derivative, the normal density, to 1e-10.
struct NormalStep {
  double value, density;
};
NormalStep normal_step(double t);

}  // namespace tribotrack::vision
