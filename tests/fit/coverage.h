// Do intervals cover the truth as often as they claim? Counted until it is decided.
#pragma once

#include <cmath>

namespace tribotrack::test {

/// Wald's sequential probability ratio test of a coverage of 95 % against 90 % and against 98 %, each decided
/// with errors of probability `error`: some 500 independent trials do for 1 in 1000, 300 for 1 in 100.
class SequentialCoverage {
 public:
  enum class Decision { undecided, nominal, too_low, too_high };
  explicit SequentialCoverage(double error = 1e-3) : bound_(-std::log(error)) {}
  void add(bool covered) {
    ++trials;
    hits += covered;
    const auto ratio = [&](double p) { return std::log(covered ? p / 0.95 : (1 - p) / 0.05); };
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

}  // namespace tribotrack::test
