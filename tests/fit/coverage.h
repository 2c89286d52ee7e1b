// Do intervals cover the truth as often as they claim? Counted until it is decided.
#pragma once

#include <algorithm>
#include <cmath>

#include "fit/fit_result.h"

namespace tribotrack::test {

/// Wald's sequential probability ratio test of a coverage of 95 % against 90 % and against 98 %, each decided
/// with errors of probability `error`: some 500 independent trials do for 1 in 1000, 300 for 1 in 100.
class SequentialCoverage {
 public:
  enum class Decision { undecided, nominal, too_low, too_high };
  explicit SequentialCoverage(double error = 1e-3) : bound_(-std::log(error)) {}
  /// `weight`: below 1 for trials that are not independent of each other, as parameters of one fit.
  void add(bool covered, double weight = 1) {
    ++trials;
    hits += covered;
    const auto ratio = [&](double p) { return weight * std::log(covered ? p / 0.95 : (1 - p) / 0.05); };
    low_ += ratio(0.90);
    high_ += ratio(0.98);
  }
  Decision decision() const {
    if (low_ >= bound_) return Decision::too_low;
    if (high_ >= bound_) return Decision::too_high;
    return low_ <= -bound_ && high_ <= -bound_ ? Decision::nominal : Decision::undecided;
  }
  bool decided() const { return decision() != Decision::undecided; }
  double share() const { return static_cast<double>(hits) / trials; }

  int trials = 0, hits = 0;

 private:
  double bound_;
  double low_ = 0, high_ = 0;  ///< log-likelihood ratios
};

/// The interval score (Gneiting and Raftery, JASA 102 (2007) 359, eq. 43), lowest for the true quantiles:
/// width + 2/alpha times how far the truth lies outside. An infinite interval scores infinity; the true 95 %
/// interval of a normal estimate 4.68 sd on average.
inline double interval_score(const fit::Interval& interval, double truth) {
  return interval.high - interval.low + 2 / 0.05 * std::max(0.0, interval.low - truth) +
         2 / 0.05 * std::max(0.0, truth - interval.high);
}
inline constexpr double kNormalScore = 4.676;

/// One interval after the other of one parameter: coverage, score, errors.
class IntervalTrials {
 public:
  void add(const fit::Interval& interval, double estimate, double truth) {
    score_ += interval_score(interval, truth);
    square_ += (estimate - truth) * (estimate - truth);
    ++count_;
  }
  /// Mean score over the rms error: kNormalScore for exact intervals, more for wider and for narrower ones.
  double relative_score() const { return score_ / count_ / std::sqrt(square_ / count_); }

 private:
  double score_ = 0, square_ = 0;
  int count_ = 0;
};

}  // namespace tribotrack::test
