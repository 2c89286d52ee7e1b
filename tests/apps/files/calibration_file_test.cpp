// What a damaged calibration is refused with. What a whole one does:
// tests/apps/commands/calibration_test.cpp.
#include "apps/files/camera.h"

#include <gmock/gmock.h>

#include <functional>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CalibrationFiles : public ProgramTest {
 protected:
  static Json whole() {
    vision::CalibrationResult result;
    vision::CameraCalibration& c = result.calibration;
    c.width = 320;
    c.height = 240;
    c.mm_per_px = 0.1;
    c.mm_per_px_sd = 0.001;
    c.lens.fx = c.lens.fy = 1000;
    c.plane.rotation.setIdentity();
    c.plane.translation = {0, 0, 100};
    return calibration_json(result);
  }
  std::string complaint(const std::function<void(Json&)>& damage) {
    Json json = whole();
    damage(json);
    put(in_folder("c.json"), text_of(json));
    return complaint_of([&] { read_calibration(in_folder("c.json")); });
  }
};

TEST_F(CalibrationFiles, WhatIsMissingOrWrongIsNamed) {
  EXPECT_EQ(complaint([](Json&) {}), "no complaint");
  EXPECT_THAT(complaint([](Json& c) { c.erase("distortion"); }),
              AllOf(HasSubstr("c.json: is no calibration: `distortion` is missing"), HasSubstr("calibrate")));
  EXPECT_THAT(complaint([](Json& c) { c["width_px"] = 320.5; }),
              HasSubstr("`width_px` must be a whole number"));
  EXPECT_THAT(complaint([](Json& c) { c["width_px"] = 1LL << 40; }), HasSubstr("`width_px`"));
  EXPECT_THAT(complaint([](Json& c) {
                c["camera_matrix"] = {{1, 2}};
              }),
              HasSubstr("`camera_matrix[1]` is missing"));
  EXPECT_THAT(complaint([](Json& c) { c["camera_matrix"][0][0] = "wide"; }),
              HasSubstr("`camera_matrix[0][0]` must be a number"));
  EXPECT_THAT(complaint([](Json& c) {
                c["plane"]["rotation"][0] = {0, 0, 0};
              }),
              HasSubstr("`plane.rotation` must be a rotation"));
  EXPECT_THAT(complaint([](Json& c) { c["mm_per_px"] = 0; }), HasSubstr("greater than 0"));
  EXPECT_THAT(complaint([](Json& c) { c = Json::array(); }), HasSubstr("must hold an object"));
}

}  // namespace
}  // namespace tribotrack::apps
