// Gauss-Legendre rules for the integrals of a synthetic scene: over a pixel and over an exposure.
#pragma once

#include <vector>

namespace tribotrack::vision {

/// mean of f over [-1/2, 1/2] = sum weights[i] f(nodes[i]); the weights add up to 1.
struct QuadratureRule {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// Exact for polynomials up to degree 2 points - 1. Throws std::invalid_argument for fewer than one point.
QuadratureRule gauss_legendre(int points);

/// Points needed for the mean over a unit interval of an edge 0.5 erfc(x / (sqrt2 blur)), to `tolerance` of
/// its height. The error is C_n max |f^(2n)|, C_n = n!^4 / ((2n + 1) (2n)!^3), and Cramer's inequality bounds
/// the derivative by 0.435 sqrt((2n - 1)!) / blur^2n. At most 256.
int gauss_points_for_edge(double blur, double tolerance);

/// Same for the wave cos(wave_number x + phase).
int gauss_points_for_wave(double wave_number, double tolerance);

}  // namespace tribotrack::vision
