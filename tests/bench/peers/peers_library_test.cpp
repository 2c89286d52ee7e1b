// The solvers of others that bench model compares with must solve the same problem: what they find at a tight
// tolerance is held against the reference in extended precision, which shares nothing with them but eq. (5).
#include <gtest/gtest.h>

#include <numbers>

#include "apps/bench/peers/library_peers.h"

namespace tribotrack::bench {

using namespace model;

namespace {

Scenario sliding() {
  Scenario s;
  s.friction = {0.1, 0.0125, 0.5, std::numbers::pi / 2, 0};
  s.cycles = 3;
  return s;
}

Scenario sticking() {
  Scenario s = sliding();
  s.friction = {0.122, 0.122 / 8, 0.5, std::numbers::pi / 6, 0};
  return s;
}

bool contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

/// The libraries this build has none of, as a reason to skip.
std::string none_built() {
  return peers::all_peers().empty() ? "this build was made without Boost.odeint and SUNDIALS" : "";
}

TEST(PeersLibrary, SegmentedOnesConvergeToTheReference) {
  if (!none_built().empty()) GTEST_SKIP() << none_built();
  int seen = 0;
  for (const Scenario& scenario : {sliding(), sticking()}) {
    const PeerResult reference = extended_precision_reference(scenario);
    ASSERT_TRUE(reference.finished);
    for (const BenchPeer& peer : peers::all_peers()) {
      // BDF restarts at order one after every switch and loses the first step from rest at loose tolerances.
      if (contains(peer.name, "by clock") || contains(peer.name, "BDF")) continue;
      const PeerResult result = peer.run(scenario, 1e-11, 1'000'000);
      EXPECT_TRUE(result.finished) << peer.name;
      EXPECT_LT((result.position - reference.position).norm(), 1e-11) << peer.name;
      EXPECT_LT((result.velocity - reference.velocity).norm(), 1e-9) << peer.name;
      ++seen;
    }
  }
  if (peers::missing_libraries().empty()) {
    EXPECT_GE(seen, 8);
  }
}

TEST(PeersLibrary, ByTheClockTheyAreWithinMicrometresWhereNothingSticks) {
  if (!none_built().empty()) GTEST_SKIP() << none_built();
  const PeerResult reference = extended_precision_reference(sliding());
  int seen = 0;
  for (const BenchPeer& peer : peers::all_peers()) {
    if (!contains(peer.name, "by clock")) continue;
    const PeerResult result = peer.run(sliding(), 1e-8, 1'000'000);
    EXPECT_TRUE(result.finished) << peer.name;
    EXPECT_LT((result.position - reference.position).norm(), 2e-4) << peer.name;
    EXPECT_GT((result.position - reference.position).norm(), 0) << peer.name;
    ++seen;
  }
  if (peers::missing_libraries().empty()) {
    EXPECT_GE(seen, 5);
  }
}

TEST(PeersLibrary, GivesUpAfterMaxSteps) {
  if (!none_built().empty()) GTEST_SKIP() << none_built();
  for (const BenchPeer& peer : peers::all_peers())
    EXPECT_FALSE(peer.run(sliding(), 1e-8, 10).finished) << peer.name;
}

}  // namespace
}  // namespace tribotrack::bench
