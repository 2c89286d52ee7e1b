#include "apps/report/data/model_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

/// At rest where it was for 2 s.
ReportRun resting_run() {
  ReportRun run;
  run.name = "a";
  run.kind = "displacement";
  for (int frame = 0; frame <= 200; ++frame) {
    run.time_s.push_back(0.01 * frame);
    run.x_mm.push_back(3);
    run.y_mm.push_back(4);
  }
  return run;
}

TEST(ReportModelPath, BeginsWhereThePartWasFirstMeasured) {
  ReportRun run = resting_run();
  run.x_mm[0] = run.y_mm[0] = no_value;
  model::Scenario scenario;
  scenario.cycles = 10;
  ASSERT_TRUE(add_model_path(scenario, false, run));
  ASSERT_EQ(run.model_x_mm.size(), run.time_s.size());
  EXPECT_TRUE(std::isnan(run.model_x_mm[0]));
  EXPECT_EQ(run.model_x_mm[1], 3);
  const model::Trajectory path = model::integrate(scenario);
  EXPECT_NEAR(run.model_x_mm[51], 3 + 1e3 * path.at(0.5).position.x(), 1e-9);
  EXPECT_NEAR(run.model_y_mm[51], 4 + 1e3 * path.at(0.5).position.y(), 1e-9);
  EXPECT_TRUE(std::isnan(run.model_x_mm[200]));  // 10 cycles end before 1.01 s
}

TEST(ReportModelPath, OfAMotionThatTakesTooLongIsLeftOutAndSaid) {
  ReportRun run = resting_run();
  EXPECT_FALSE(add_model_path(model::Scenario{}, false, run, 5));
  EXPECT_TRUE(run.model_x_mm.empty());
  EXPECT_FALSE(run.cycle_x_mm.empty());
  ReportData data;
  note_no_model_path(run, data);
  EXPECT_THAT(data.warnings, testing::ElementsAre(testing::HasSubstr("run a: the model's path is left out")));
}

}  // namespace
}  // namespace tribotrack::apps
