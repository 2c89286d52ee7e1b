// Score tests of everything that a fit takes as exact, and the refits of what they speak for.
//
// With r the whitened residuals at the minimum, J their derivatives by the unknowns and G those by something
// that the fit holds at a value (a tilt, a law's strength, one run's two numbers), chi^2 with it free is
// lower by
//   b' S^-1 b,  b = G_' r,  S = G_' G_,  G_ = (1 - J (J'J)^-1 J') G,
// to first order, at s = -S^-1 b: Rao's score test (C. R. Rao, Math. Proc. Cambridge Phil. Soc. 44, 1948,
// 50-57). It takes no refit. What is known to an sd is an unknown of the fit already: there G is the row of
// its prior, and the test asks what chi^2 would be without it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "fit/fit_result.h"
#include "fit/minimum/minimise.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// The name of a spin of free slides that was not seen: found by a refit, not by a score test.
inline constexpr const char* kUnseenSpin = "unseen_spin";
/// Friction that falls with speed: score tests see it at one of the speeds at which it may have fallen.
inline constexpr const char* kStribeck = "stribeck";

/// What the fit takes as exact, or as known to an sd.
struct Candidate {
  const char* name;
  const char* what;  ///< before its size
  const char* unit;
  double per_unit;  ///< of the unit, in one of the quantity's; 0: per cent of its own value
  std::vector<FitParameter> quantities;
  bool never_negative = false;
};

const std::vector<Candidate>& candidates();

/// The same problem with quantities free that are conditions at the most.
Problem with_free(Problem problem, const std::vector<FitParameter>& quantities);

/// Of slides whose spin was not seen: the edge of each moves half as fast as it slides, with an sd of as
/// much.
std::optional<Problem> with_unseen_spin(Problem problem, const Unknowns& unknowns,
                                        const Eigen::VectorXd& values);

class ScoreTests {
 public:
  /// Refers to all it is given.
  ScoreTests(const Residuals& residuals, const Minimum& best, int threads);
  bool empty() const { return at_.empty(); }

  /// To first order; nullopt where it is fitted anyway, or the data do not see it beside the unknowns.
  std::optional<Explanation> test(const Candidate& candidate) const;
  /// A run's two numbers, as if it had not been measured.
  std::optional<Explanation> test_run(std::size_t run) const;
  /// Friction that differs from run to run.
  std::optional<Explanation> test_scatter() const;
  /// The fit in another problem of the same runs, from here or homed in. Where it ends, for this one's
  /// unknowns; empty where it fails.
  Eigen::VectorXd refit(const Problem& problem, const Candidate* candidate, bool home_in,
                        Explanation& found) const;

 private:
  /// Products of columns G with themselves, with J and with r.
  struct Products {
    Eigen::MatrixXd own, with_unknowns;  ///< G'G, G'J
    Eigen::VectorXd with_residuals;      ///< G'r
  };
  Problem with_all_free() const;
  Residuals of(const Unknowns& unknowns, const Eigen::VectorXd& values) const;
  Products products(Eigen::Index size) const;
  std::optional<Explanation> test(const Products& g) const;
  void tell_spin(const Unknowns& unknowns, const Eigen::VectorXd& values, const Linearised& at,
                 Explanation& found) const;
  void tell_size(const Candidate& candidate, double size, double sd, Explanation& found) const;

  const Residuals& residuals_;
  const Unknowns& unknowns_;
  const Problem& problem_;
  const Minimum& best_;
  int threads_;
  Eigen::VectorXd values_;
  Problem wide_problem_;  ///< everything free
  Unknowns wide_;
  Linearised at_;
  Eigen::MatrixXd normal_, information_;
  Eigen::VectorXd gradient_, step_;
  std::vector<Eigen::Index> columns_;  ///< of the fit's own unknowns
};

}  // namespace tribotrack::fit::internal
