// The source paper's figures and claims, computed again: one page, tables for other programs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/figures/figure.h"
#include "apps/program/context.h"

namespace tribotrack::apps {

enum class Verdict {
  exact,          ///< a law of the model: holds to rounding
  holds,          ///< in the whole range looked at
  holds_in_part,  ///< in part of it: the numbers say where not
  refuted,
};
const char* to_string(Verdict verdict);

/// What the paper says.
struct Statement {
  int figure;         ///< of the paper: the one that shows it, or comes nearest to it
  const char* name;   ///< short, one word or two
  const char* place;  ///< its section or figure
  /// In the paper's own words, "[...]" where some are left out; its symbols as words: "phi", "A_e", "3 pi/2".
  const char* statement;
  const char *quantity, *unit;  ///< of the number that decides; unit "": a pure number
};

/// What is found: the verdict follows from the number.
struct Answer {
  Verdict verdict;
  double value;
  std::string finding = {};     ///< one sentence
  std::string conditions = {};  ///< beside the paper's own: mu2 = mu1/8, A = 0.28 mm, w = 62.8 rad/s, ...
};

struct Claim : Statement, Answer {};

/// In the order of the paper's figures. `progress`: called after each.
std::vector<Claim> paper_claims(const Context& context,
                                const std::function<void(int done, int total)>& progress = {});

/// What stands beside a figure but the claims; "": nothing.
struct FigureText {
  int number;  ///< of the paper's figure
  const char* heading;
  const char* taken;      ///< what the caption leaves open, and what is taken for it
  const char* agreement;  ///< what the paper says of its measurements
};

struct PaperFigure : FigureText, Figure {};

/// Figures 3 to 7 and the model's side of 9 to 11, named "figure3" .. "figure11", from data/figure*.toml as
/// they were when the program was built.
std::vector<PaperFigure> paper_figures(const Context& context);

struct Paper {
  std::vector<PaperFigure> figures;
  std::vector<Claim> claims;
};

/// The self-contained page: all claims with verdict and number first, then each figure with its claims beside
/// it.
std::string page_of(const Paper& paper);

/// One row a claim: figure, place, claim, verdict, the number that decides, the paper's sentence, what is
/// found.
std::string claims_csv(const Paper& paper);

/// "4 exact, 7 hold, 7 hold in part, 2 refuted".
std::string verdicts_text(const std::vector<Claim>& claims);

}  // namespace tribotrack::apps
