// What Kilikevicius et al. 2021 state about the motion (sections 2.2 and 4), computed again: where it is
// exactly true, where nearly, where not. Each verdict follows from the figures beside it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::bench {

enum class Verdict {
  exact,          ///< a law of the model: holds to rounding
  holds,          ///< in the whole range looked at
  holds_in_part,  ///< in part of it: the figures say where it fails
  fails,
};

/// One number that was found.
struct ClaimFigure {
  std::string conditions;  ///< beside the paper's own (see paper_conditions)
  std::string quantity;
  double value = 0;  ///< NaN: does not exist
  std::string unit;  ///< "" for a pure number
};

struct PaperClaim {
  std::string name;       ///< short, one word or two
  std::string statement;  ///< as the paper has it
  std::string place;      ///< its section or figure
  Verdict verdict = Verdict::fails;
  std::string finding;  ///< one sentence
  std::vector<ClaimFigure> figures;
};

struct ClaimOptions {
  bool quick = false;  ///< coarser sweeps: a check that it works
  std::function<void(int done, int total)> progress;
};

/// mu2 = mu1/8, g = 9.81 m/s^2, A = 0.28 mm, w = 62.8 rad/s, epsilon = pi/2, 20 cycles from rest.
model::Scenario paper_conditions(double mu1, double dtau, double phi = 0);

std::vector<PaperClaim> paper_claims(const ClaimOptions& options = {});

/// Where v is greatest over dtau (rad), found to 1e-6; mu1, mu2, A, w as in the scenario. v of the steady
/// motion, or over the scenario's cycles from rest.
double width_of_greatest_v(model::Scenario scenario, bool steady = true);

const char* to_string(Verdict verdict);

}  // namespace tribotrack::bench
