#include "apps/bench/claims/claims.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <set>

#include "apps/bench/claims/sweeps.h"
#include "model/steady_orbit.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

const std::vector<PaperClaim>& claims() {
  static const std::vector<PaperClaim> found = [] {
    ClaimOptions options;
    options.quick = true;
    return paper_claims(options);
  }();
  return found;
}

const PaperClaim& claim(const std::string& name) {
  for (const PaperClaim& c : claims())
    if (c.name == name) return c;
  throw std::runtime_error("no claim " + name);
}

double largest(const PaperClaim& c, const std::string& quantity) {
  double most = -HUGE_VAL;
  for (const ClaimFigure& f : c.figures)
    if (f.quantity == quantity) most = std::max(most, f.value);
  return most;
}

TEST(Claims, EachHasFiguresAndAFinding) {
  std::set<std::string> names;
  for (const PaperClaim& c : claims()) {
    EXPECT_TRUE(names.insert(c.name).second) << c.name;
    EXPECT_FALSE(c.statement.empty() || c.place.empty() || c.finding.empty()) << c.name;
    EXPECT_FALSE(c.figures.empty()) << c.name;
    EXPECT_TRUE(c.figure >= 3 && c.figure <= 11) << c.name;
    EXPECT_TRUE(std::isfinite(c.deciding.value) && !c.deciding.quantity.empty()) << c.name;
    for (const ClaimFigure& f : c.figures)
      EXPECT_TRUE(std::isfinite(f.value)) << c.name << ": " << f.conditions << ", " << f.quantity;
  }
  EXPECT_EQ(claims().size(), 20u);
}

TEST(Claims, CircularEndStateIsExact) {
  const PaperClaim& c = claim("circular end state");
  EXPECT_EQ(c.verdict, Verdict::exact);
  EXPECT_LT(largest(c, "radius off its closed form, relative"), 1e-12);
  EXPECT_LT(largest(c, "drift per cycle over A"), 1e-11);
}

TEST(Claims, SteadyAlphaHasSlopeMinusOneInPhiExactly) {
  const PaperClaim& c = claim("alpha linear in phi");
  EXPECT_EQ(c.verdict, Verdict::exact);
  EXPECT_LT(largest(c, "alpha off slope -1, steady"), 1e-9);
  // The facts known before, from rest: 3.4 deg at mu1 = .1, dtau = pi/6; 1.0 at .12, pi/3.
  const auto off = [](double mu1, double dtau) {
    return degrees(sweep_phase(paper_conditions(mu1, dtau), drift_from_rest, 72).off_line);
  };
  EXPECT_NEAR(off(0.1, pi / 6), 3.4, 0.1);
  EXPECT_NEAR(off(0.12, pi / 3), 1.0, 0.1);
}

TEST(Claims, SteadyVDoesNotDependOnPhi) {
  const PaperClaim& c = claim("v over phi");
  EXPECT_EQ(c.verdict, Verdict::exact);
  EXPECT_LT(largest(c, "spread of v, steady"), 1e-9);
  EXPECT_GT(largest(c, "spread of v, 20 cycles from rest"), 1);  // from rest it does
}

TEST(Claims, AlphaTurnsOnceOverPhi) {
  for (const ClaimFigure& f : claim("full circle").figures) EXPECT_NEAR(f.value, -1, 1e-12);
}

/// v has its greatest value where its slope in dtau vanishes: by central differences around it.
TEST(Claims, GreatestVIsAMaximum) {
  for (const double mu1 : {0.08, 0.12}) {
    Scenario s = paper_conditions(mu1, 0);
    const double widest = width_of_greatest_v(s);
    const auto v = [&](double dtau) {
      s.friction.pulse_width = dtau;
      return steady_drift(s).v;
    };
    const double h = 1e-3, slope = (v(widest + h) - v(widest - h)) / (2 * h),
                 curvature = (v(widest + h) - 2 * v(widest) + v(widest - h)) / (h * h);
    EXPECT_LT(curvature, 0);
    EXPECT_NEAR(-slope / curvature, 0, 1e-4) << "distance from the maximum, rad";
    std::cout << "mu1 = " << mu1 << ": greatest v at dtau = " << widest << '\n';
  }
}

/// A weak pulse: alpha = d0 + arg(2/k - i/w) - phi - dtau/2, so its slope in dtau is -1/2 exactly.
TEST(Claims, WeakPulsesTurnAlphaByHalfTheirWidth) {
  const auto alpha = [](double weak, double dtau) {
    Scenario s = paper_conditions(0.1, dtau);
    s.friction.reduced = s.friction.nominal * (1 - weak);
    return steady_drift(s).alpha;
  };
  const auto off = [&](double weak) { return turn_between(alpha(weak, 1), alpha(weak, 2)) + 0.5; };
  EXPECT_NEAR(off(1e-4), 0, 1e-4);
  EXPECT_NEAR(off(1e-4) / off(2e-4), 0.5, 1e-2);  // and the rest is linear in mu1 - mu2
}

TEST(Claims, TiltMattersMostAtNarrowPulses) {
  const auto turned = [](double dtau) -> double {
    for (const ClaimFigure& f : claim("tilt").figures)
      if (f.quantity == "0.1 deg of tilt turns alpha by up to, steady" &&
          f.conditions.find(dtau < 1 ? "0.524" : "3.142") != std::string::npos)
        return f.value;
    return NAN;
  };
  EXPECT_NEAR(turned(pi / 6), 12, 1);
  EXPECT_LT(turned(pi), 0.5 * turned(pi / 6));
}

TEST(Claims, ThreadsChangeNothing) {
  ClaimOptions options;
  options.quick = true;
  options.threads = 3;
  const std::vector<PaperClaim> others = paper_claims(options);
  ASSERT_EQ(others.size(), claims().size());
  for (std::size_t k = 0; k < others.size(); ++k) {
    EXPECT_EQ(others[k].name, claims()[k].name);
    EXPECT_EQ(others[k].deciding.value, claims()[k].deciding.value) << others[k].name;
  }
}

/// One displacement for every phi and both widths: what is at least and at most so of the path.
TEST(Claims, WiderPulsesStretchTheTrajectory) {
  const PaperClaim& c = claim("less stretched");
  EXPECT_EQ(c.verdict, Verdict::refuted);
  EXPECT_STREQ(to_string(c.verdict), "refuted");
  EXPECT_GT(c.deciding.value, largest(c, "displacement over path, dtau = pi/6"));
}

TEST(Claims, AmplitudeAndFrequencyMoveSteadyAlphaTogether) {
  const PaperClaim& c = claim("alpha over omega");
  EXPECT_EQ(c.verdict, Verdict::exact);
  EXPECT_LT(c.deciding.value, 1e-9);
}

TEST(Claims, VelocityGrowsInTheRangeOfTheExperiment) {
  EXPECT_EQ(claim("v over dtau, measured").verdict, Verdict::holds);
  EXPECT_EQ(claim("further at wider dtau").verdict, Verdict::holds);
  EXPECT_GT(claim("further at wider dtau").deciding.value, 1);
  EXPECT_EQ(claim("displacement over dtau").verdict, Verdict::holds_in_part) << "it falls after its maximum";
  EXPECT_EQ(claim("alpha mostly by phi").verdict, Verdict::holds);
  EXPECT_GT(claim("keeps moving").deciding.value, 1);
}

TEST(Claims, StepBackIsFromTheHighestBefore) {
  EXPECT_DOUBLE_EQ(deepest_step_back({1, 2, 1.5, 1, 3, 2.7}, 1), 0.5);
  EXPECT_DOUBLE_EQ(deepest_step_back({4, 2, 3, 1}, -1), 0.5);
  EXPECT_EQ(deepest_step_back({0, 1, 2}, 1), 0);
}

TEST(Claims, MonotonyFindsTheFirstStretchAgainstTheSign) {
  const std::vector<double> x{0, 1, 2, 3, 4, 5}, v{1, 2, 1.5, 1, 3, 2};
  const auto m = monotony(x, v, 1);
  EXPECT_FALSE(m.holds);
  EXPECT_EQ(m.fails_from, 1);
  EXPECT_EQ(m.fails_to, 3);
  EXPECT_TRUE(monotony(x, x, 1).holds);
  EXPECT_FALSE(monotony(x, x, -1).holds);
}

}  // namespace
}  // namespace tribotrack::bench
