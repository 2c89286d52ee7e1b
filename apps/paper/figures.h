// The paper's figures, computed again.
#pragma once

#include <functional>
#include <vector>

#include "apps/figures/figure.h"

namespace tribotrack::apps {

/// Figures 3 to 7 and the model's side of 9 to 11, named "figure3" .. "figure11". `threads` shortens the work
/// and changes nothing.
std::vector<Figure> paper_figures(int threads);

/// The number of the paper's figure.
int number_of(const Figure& figure);

/// Trajectories: figures 3, 4, 5 and 11. Millimetres, both axes to the same scale.
std::vector<Figure> paper_trajectories();

/// alpha and v along a parameter: figures 6, 7, 9 and 10.
std::vector<Figure> paper_dependences(int threads);

}  // namespace tribotrack::apps
