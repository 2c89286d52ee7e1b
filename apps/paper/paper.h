// The source paper's figures and claims, computed again: one page, tables for other programs.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/claims/claims.h"
#include "apps/figures/figure.h"

namespace tribotrack::apps {

struct Paper {
  std::vector<Figure> figures;            ///< by number
  std::vector<bench::PaperClaim> claims;  ///< in the order of the figures they belong to
};

/// `options.threads` serve the figures, too.
Paper paper_of(const bench::ClaimOptions& options);

/// The self-contained page: all claims with verdict and number first, then each figure with its claims beside
/// it.
std::string page_of(const Paper& paper);

/// One row a claim: figure, place, claim, verdict, the number that decides, the paper's sentence, what is
/// found.
std::string claims_csv(const Paper& paper);

/// "4 exact, 7 hold, 7 hold in part, 2 refuted".
std::string verdicts_text(const std::vector<bench::PaperClaim>& claims);

}  // namespace tribotrack::apps
