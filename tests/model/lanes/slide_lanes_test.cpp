#include "model/lanes/slide_lanes.h"

#include <gtest/gtest.h>

#include <complex>

#include "model/processor/instruction_set.h"
#include "model/random_scenario.h"

namespace tribotrack::model::internal {
namespace {

using Complex = std::complex<double>;
constexpr int kWidth = SlideLanes::kWidth;
constexpr unsigned kSeed = 31;
const Complex kI(0, 1);

/// Every lane the same but for what the test changes.
SlideLanes lanes_of(double kappa, Complex v, double left) {
  SlideLanes lanes{};
  for (int k = 0; k < kWidth; ++k) {
    lanes.kappa[k] = kappa;
    lanes.left[k] = left;
    lanes.tolerance[k] = 1e-14;
    lanes.vx[k] = v.real();
    lanes.vy[k] = v.imag();
    lanes.ux[0][k] = lanes.uy[1][k] = 1;
  }
  return lanes;
}
Complex velocity(const SlideLanes& lanes, int k = 0) {
  return {lanes.vx[k], lanes.vy[k]};
}
Complex displacement(const SlideLanes& lanes, int k = 0) {
  return {lanes.zx[k], lanes.zy[k]};
}
void go_on(SlideStep step, SlideLanes& lanes) {
  for (int i = 0; i < 1000 && lanes.left[0] > 0; ++i) step(lanes);
}

class SlideLanesTest : public ::testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override { use_instruction_set(GetParam()); }
  void TearDown() override { use_instruction_set(available_instruction_sets().back()); }
};

/// v = -i + (v0 + i) e^{-it}, z = (v0 + i) t e^{-it} - (1 - e^{-it}).
TEST_P(SlideLanesTest, WithoutFrictionTheDriveAlone) {
  const Complex v0(0.7, 0.4);
  const double t = 2.9;
  SlideLanes lanes = lanes_of(0, v0, t);
  go_on(slide_machines().slide.alone, lanes);
  const Complex turn = std::exp(-kI * t), c = v0 + kI;
  EXPECT_LT(std::abs(velocity(lanes) - (c * turn - kI)), 1e-13);
  EXPECT_LT(std::abs(displacement(lanes) - (c * t * turn - (1.0 - turn))), 1e-13);
}

/// cos d0 = kappa, r = sin d0 (section 2.2 of the paper).
TEST_P(SlideLanesTest, SteadyCircleStaysAsItIs) {
  for (const double kappa : {0.01, 0.3, 0.9, 0.999}) {
    const double r = std::sqrt(1 - kappa * kappa), t = 2 * std::numbers::pi;
    const Complex v(r * kappa, -r * r);
    SlideLanes lanes = lanes_of(kappa, v, t);
    go_on(slide_machines().slide.alone, lanes);
    EXPECT_LT(std::abs(velocity(lanes) - v), 2e-14) << kappa;
    EXPECT_LT(std::abs(displacement(lanes)), 2e-13) << kappa;  // once round
  }
}

/// Two halves of a way are the whole, whatever the steps.
TEST_P(SlideLanesTest, TheStartGoesOnAsSliding) {
  for (const double kappa : {0.0, 0.2, 0.7, 0.95}) {
    const double t = 0.1;
    SlideLanes whole = lanes_of(kappa, 0, t), half = lanes_of(kappa, 0, 0.4 * t);
    slide_machines().start(whole);
    slide_machines().start(half);
    ASSERT_EQ(whole.left[0], 0) << "the test needs a start in one step";
    for (int k = 0; k < kWidth; ++k) half.left[k] = 0.6 * t;
    go_on(slide_machines().slide.alone, half);
    EXPECT_LT(std::abs(velocity(whole) - velocity(half)), 1e-14) << kappa;
    EXPECT_LT(std::abs(displacement(whole) - displacement(half)), 1e-15) << kappa;
    // |v| = (1 - kappa) t at first, along the drive
    EXPECT_NEAR(std::abs(velocity(whole)), (1 - kappa) * t, t * t * t);
  }
}

/// The same motion in t and in sigma, and a creeping step that would pass the end is not taken.
TEST_P(SlideLanesTest, CreepingAndSlidingAgree) {
  for (const double kappa : {0.0, 0.5, 1.1, 2.0}) {
    const Complex v(0.05, -0.04);
    const double t = 0.04;
    SlideLanes slid = lanes_of(kappa, v, t), crept = slid;
    go_on(slide_machines().slide.with_neighbours, slid);
    int steps = 0;
    for (; steps < 1000 && crept.left[0] > 0; ++steps) {
      const SlideLanes before = crept;
      slide_machines().creep.with_neighbours(crept);
      if (crept.left[0] < 0) {
        EXPECT_EQ(crept.left[0], -before.left[0]);
        EXPECT_EQ(velocity(crept), velocity(before));
        EXPECT_EQ(displacement(crept), displacement(before));
      }
    }
    ASSERT_LT(crept.left[0], 0);
    for (double& left : crept.left) left = -left;
    go_on(slide_machines().slide.with_neighbours, crept);
    EXPECT_LT(std::abs(velocity(crept) - velocity(slid)), 1e-14) << kappa;
    EXPECT_LT(std::abs(displacement(crept) - displacement(slid)), 1e-15) << kappa;
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR(crept.ux[i][0], slid.ux[i][0], 1e-4) << kappa;
      EXPECT_NEAR(crept.uy[i][0], slid.uy[i][0], 1e-4) << kappa;
    }
  }
}

/// Neighbours are what differences of motions show, and distances never grow.
TEST_P(SlideLanesTest, NeighboursAreDifferences) {
  std::cout << "seed " << kSeed << "\n";
  RandomScenario random(kSeed);
  for (int n = 0; n < 30; ++n) {
    const double kappa = random.uniform(0, 0.9), t = random.uniform(0.2, 3), h = 1e-5;
    const Complex v(random.uniform(-1, 1), random.uniform(-1, 1));
    SlideLanes lanes = lanes_of(kappa, v, t);
    lanes.vx[1] += h;
    lanes.vx[2] -= h;
    lanes.vy[3] += h;
    lanes.vy[4] -= h;
    for (int i = 0; i < 1000; ++i) slide_machines().slide.with_neighbours(lanes);
    const double near = 1e-3;
    for (int i = 0; i < 2; ++i) {
      const int up = 2 * i + 1;
      const Complex dv = (velocity(lanes, up) - velocity(lanes, up + 1)) / (2 * h);
      const Complex dz = (displacement(lanes, up) - displacement(lanes, up + 1)) / (2 * h);
      EXPECT_LT(std::abs(dv - Complex(lanes.ux[i][0], lanes.uy[i][0])), near)
          << kappa << " " << v << " " << t;
      EXPECT_LT(std::abs(dz - Complex(lanes.yx[i][0], lanes.yy[i][0])), near)
          << kappa << " " << v << " " << t;
      EXPECT_LE(std::abs(dv), 1 + 1e-9);
    }
  }
}

/// Who travels with whom leaves no trace.
TEST_P(SlideLanesTest, LanesKnowNothingOfEachOther) {
  std::cout << "seed " << kSeed << "\n";
  RandomScenario random(kSeed);
  SlideLanes lanes = lanes_of(0, 0, 1);
  for (int k = 0; k < kWidth; ++k) {
    lanes.kappa[k] = random.uniform(0, 1.5);
    lanes.left[k] = random.uniform(0.01, 1);
    lanes.vx[k] = random.uniform(-1, 1);
    lanes.vy[k] = random.uniform(-1, 1);
  }
  const SlideMachines machines = slide_machines();
  for (const SlideStep step : {machines.start, machines.slide.alone, machines.slide.with_neighbours,
                               machines.creep.alone, machines.creep.with_neighbours}) {
    SlideLanes together = lanes;
    step(together);
    for (int k = 0; k < kWidth; ++k) {
      SlideLanes company = lanes_of(lanes.kappa[k], velocity(lanes, k), lanes.left[k]);
      company.kappa[(k + 1) % kWidth] = 0.3;
      step(company);
      EXPECT_EQ(velocity(company, k), velocity(together, k));
      EXPECT_EQ(displacement(company, k), displacement(together, k));
      EXPECT_EQ(company.left[k], together.left[k]);
      EXPECT_EQ(company.ux[1][k], together.ux[1][k]);
      EXPECT_EQ(company.yy[0][k], together.yy[0][k]);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, SlideLanesTest, ::testing::ValuesIn(available_instruction_sets()));

}  // namespace
}  // namespace tribotrack::model::internal
