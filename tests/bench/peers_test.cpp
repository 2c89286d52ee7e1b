#include "apps/bench/peers.h"

#include <gtest/gtest.h>

#include <numbers>

#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

/// 20 cycles at mu1 = 0.1, mu2 = 0.0125, phi = 0.5, dtau = pi/2 from rest; end point by Taylor series with
/// segments, to 1e-16 m.
const Vector2d kReference(5.470210818697445e-3, -1.098396194698849e-2);

Scenario slipping() {
  Scenario s;
  s.friction = {0.1, 0.0125, 0.5, pi / 2, 0};
  return s;
}

TEST(Peers, PaperRecipeEndsWithinItsKnownError) {
  // An end error of some 1e-5 m: the step control does not see the friction switches.
  const PeerResult result = paper_recipe(slipping());
  EXPECT_TRUE(result.finished);
  const double error = (result.position - kReference).norm();
  EXPECT_LT(error, 1.2e-5);
  EXPECT_GT(error, 1e-7);
  EXPECT_GE(result.steps, 20010);  // 2.001 s at no more than 1e-4 s
}

TEST(Peers, ExtendedPrecisionReferenceHasTheKnownDigitsAndThoseOfTheLibrary) {
  const PeerResult result = extended_precision_reference(slipping(), 1e-16);
  EXPECT_TRUE(result.finished);
  EXPECT_LT((result.position - kReference).norm(), 2e-16);
  EXPECT_LT((result.position - integrate(slipping()).end().position).norm(), 1e-16);
}

TEST(Peers, ReferenceAgreesWithTheLibraryWhereThePartSticks) {
  Scenario s = slipping();
  s.friction.nominal = 0.122;
  s.friction.reduced = 0.122 / 8;
  s.friction.pulse_width = pi / 6;
  s.cycles = 3;
  const PeerResult result = extended_precision_reference(s, 1e-15);
  EXPECT_TRUE(result.finished);
  EXPECT_EQ(result.velocity, Vector2d(0, 0));
  EXPECT_LT((result.position - integrate(s).end().position).norm(), 1e-16);
  // Free of error where the stop is seen, of the order of the tolerance times A otherwise.
  const PeerResult coarse = dormand_prince(s, 1e-8);
  EXPECT_LT((coarse.position - result.position).norm(), 1e-10);
}

TEST(Peers, MoreauJeanIsOfFirstOrderAndStopsAFreeSlide) {
  const double coarse = (moreau_jean(slipping(), 4e-5).position - kReference).norm();
  const double fine = (moreau_jean(slipping(), 1e-5).position - kReference).norm();
  EXPECT_NEAR(coarse / fine, 4, 0.6);

  Scenario slide;
  slide.drive.amplitude = slide.drive.amplitude_y = 0;
  slide.initial_velocity = {0.3, 0.4};
  slide.duration = 1;
  const double path = 0.25 / (2 * slide.friction.nominal * slide.drive.gravity);
  const PeerResult result = moreau_jean(slide, 1e-5);
  EXPECT_EQ(result.velocity, Vector2d(0, 0));
  EXPECT_LT((result.position - path * Vector2d(0.6, 0.8)).norm(), 1e-5 * 0.5);
}

/// What libraries find at a tight tolerance is held against the reference in extended precision, which shares
/// nothing with them but eq. (5).
TEST(PeersLibrary, ConvergeToTheReferenceAndGiveUpAfterMaxSteps) {
  Scenario sliding = slipping(), sticking = slipping();
  sliding.cycles = sticking.cycles = 3;
  sticking.friction = {0.122, 0.122 / 8, 0.5, pi / 6, 0};
  for (const Scenario& scenario : {sliding, sticking}) {
    const PeerResult reference = extended_precision_reference(scenario);
    ASSERT_TRUE(reference.finished);
    for (const BenchPeer& peer : library_peers()) {
      EXPECT_FALSE(peer.run(scenario, 1e-8, 10).finished) << peer.name;
      // BDF restarts at order one after every switch and loses the first step from rest at loose tolerances.
      if (peer.name.find("BDF") != std::string::npos) continue;
      const PeerResult result = peer.run(scenario, 1e-11, 1'000'000);
      EXPECT_TRUE(result.finished) << peer.name;
      EXPECT_LT((result.position - reference.position).norm(), 1e-11) << peer.name;
      EXPECT_LT((result.velocity - reference.velocity).norm(), 1e-9) << peer.name;
    }
  }
}

}  // namespace
}  // namespace tribotrack::bench
