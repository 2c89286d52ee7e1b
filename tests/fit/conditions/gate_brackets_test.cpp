// Frames that meet every turn at the same phases leave the same part of an edge open, in all runs alike.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "fit/conditions.h"

namespace tribotrack::fit {
namespace {

using model::Parameter;

constexpr double kBracket = 0.134;
const double kEdge = kBracket / std::sqrt(12.0);

/// Runs whose lamps show phi off by so much of what was commanded.
std::vector<RunEvidence> runs_off_by(const std::vector<double>& off) {
  std::vector<RunEvidence> runs;
  for (std::size_t k = 0; k < off.size(); ++k) {
    RunEvidence run;
    run.phi.value = 0.7 * static_cast<double>(k);
    run.dtau.value = 1;
    run.gate.emplace();
    run.gate->phi = {run.phi.value + off[k], kEdge};
    run.gate->dtau = {1, std::sqrt(2.0) * kEdge};
    run.gate->covariance = -kEdge * kEdge;
    run.gate->bracket = kBracket;
    run.gate_by_camera = true;
    runs.push_back(run);
  }
  return runs;
}

Conditions pooled(const std::vector<RunEvidence>& runs) {
  std::vector<RunConditions> start;
  for (const RunEvidence& run : runs) start.push_back({{}, settle_timing(run).own});
  return pool(runs, {}, start);
}

double shared_sd(const Conditions& conditions) {
  double variance = 0;
  for (const SharedError& error : conditions.errors)
    if (error.quantity == FitParameter::phase_reference) variance += error.sd * error.sd;
  return std::sqrt(variance);
}

TEST(GateBrackets, AlikeInAllRunsTheyAreOneError) {
  const Conditions conditions = pooled(runs_off_by(std::vector<double>(6, 0.03)));
  EXPECT_NEAR(shared_sd(conditions), kEdge, 1e-12);
  for (const RunConditions& run : conditions.runs) {
    EXPECT_NEAR(run.own.sd(Parameter::phi), 0, 1e-9);
    EXPECT_NEAR(run.own.sd(Parameter::dtau), std::sqrt(2.0) * kEdge, 1e-12);
  }
}

TEST(GateBrackets, EachItsOwnTheyAreNone) {
  std::mt19937 random(1);
  std::uniform_real_distribution<> anywhere(-kBracket / 2, kBracket / 2);
  int shared = 0;
  for (int k = 0; k < 200; ++k) {
    std::vector<double> off;
    for (int i = 0; i < 8; ++i) off.push_back(anywhere(random));
    const Conditions conditions = pooled(runs_off_by(off));
    shared += shared_sd(conditions) > 0;
    EXPECT_LE(shared_sd(conditions), kEdge);
  }
  EXPECT_LE(shared, 20) << "by chance in 5 %";
}

}  // namespace
}  // namespace tribotrack::fit
