// What Kilikevicius et al. 2021 state about the motion (sections 2.2, 3.2 and 4), computed again: where it is
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
  holds_in_part,  ///< in part of it: the figures say where not
  refuted,
};

/// One number that was found.
struct ClaimFigure {
  std::string conditions;  ///< beside the paper's own (see paper_conditions)
  std::string quantity;
  double value = 0;  ///< NaN: does not exist
  std::string unit;  ///< "" for a pure number
};

struct PaperClaim {
  std::string name = {};  ///< short, one word or two
  /// In the paper's own words, "[...]" where some are left out; its symbols as words: "phi", "A_e", "3 pi/2".
  std::string statement = {};
  std::string place = {};  ///< its section or figure
  int figure = 0;          ///< of the paper: the one that shows it, or comes nearest to it
  Verdict verdict = Verdict::refuted;
  std::string finding = {};  ///< one sentence
  std::vector<ClaimFigure> figures = {};
  ClaimFigure deciding = {};  ///< the number that the verdict rests on
};

struct ClaimOptions {
  bool quick = false;                                 ///< coarser sweeps: a check that it works
  int threads = 1;                                    ///< figures do not depend on it
  std::function<void(int done, int total)> progress;  ///< called by one thread at a time
};

/// In the order of the paper's figures.
std::vector<PaperClaim> paper_claims(const ClaimOptions& options = {});

/// mu2 = mu1/8, g = 9.81 m/s^2, A = 0.28 mm, w = 62.8 rad/s, epsilon = pi/2, 20 cycles from rest.
model::Scenario paper_conditions(double mu1, double dtau, double phi = 0);

/// Where v is greatest over dtau (rad), found to 1e-6; mu1, mu2, A, w as in the scenario. v of the steady
/// motion, or over the scenario's cycles from rest.
double width_of_greatest_v(model::Scenario scenario, bool steady = true);

const char* to_string(Verdict verdict);

}  // namespace tribotrack::bench
