// The interval a fit quotes for one parameter, and how good it is.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "fit/fit_result.h"

namespace tribotrack::bench {

/// Its pieces: more than one where minima lie apart.
template <class Parameter>
std::vector<fit::Interval> quoted_pieces(const Parameter& parameter) {
  if constexpr (requires { parameter.ci95_pieces.size(); })
    if (parameter.ci95_pieces.size() > 1) return {parameter.ci95_pieces.begin(), parameter.ci95_pieces.end()};
  return {parameter.ci95};
}

/// How far a value lies outside a piece; 0 within. A lag is known modulo a turn. NaN is outside everything.
inline double outside(const fit::Interval& piece, double value, bool turns) {
  if (turns && std::isfinite(piece.low)) {
    constexpr double kTurn = 2 * std::numbers::pi;
    value += kTurn * std::ceil((piece.low - value) / kTurn);  // the first one not below it
    return value <= piece.high ? 0 : std::min(value - piece.high, piece.low - (value - kTurn));
  }
  if (!(piece.low <= piece.high)) return std::numeric_limits<double>::infinity();
  return std::max({0.0, piece.low - value, value - piece.high});
}

/// What was quoted for a parameter, against the truth.
struct JudgedInterval {
  bool open = false;   ///< infinite on a side, or the whole turn of a lag
  bool holds = false;  ///< an open one may, too
  /// Score (Gneiting and Raftery, JASA 102 (2007) 359, eq. 43: width + 2/alpha times how far the truth lies
  /// outside; for pieces their widths together and the nearest) over that which the exact interval of a
  /// normal estimate of standard deviation `bound` has on average. 1 is as good as can be; cut at
  /// kWorstScore, which an open one has.
  double score = 0;
};

inline constexpr double kWorstScore = 10;
/// Mean score of estimate -+ 1.96 sd for sd = 1: 2 * 1.96 + 2/0.05 * 2 (phi(1.96) - 1.96 * 0.025).
inline constexpr double kNormalScore = 4.6756;

inline JudgedInterval judge_pieces(const std::vector<fit::Interval>& pieces, double truth, double bound,
                                   bool turns) {
  JudgedInterval judged;
  double width = 0, off = std::numeric_limits<double>::infinity();
  for (const fit::Interval& piece : pieces) {
    width += piece.high - piece.low;
    off = std::min(off, outside(piece, truth, turns));
  }
  judged.open = !std::isfinite(width) || (turns && width >= 2 * std::numbers::pi * (1 - 1e-9));
  judged.holds = off == 0;
  judged.score =
      judged.open ? kWorstScore : std::min(kWorstScore, (width + 2 / 0.05 * off) / (kNormalScore * bound));
  return judged;
}

inline JudgedInterval judge_quoted(const fit::ParameterEstimate& parameter, double truth, double bound) {
  return judge_pieces(quoted_pieces(parameter), truth, bound, parameter.parameter == fit::FitParameter::lag);
}

}  // namespace tribotrack::bench
