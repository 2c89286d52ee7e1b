// What a damaged calibration is refused with. What a whole one does:
// tests/apps/commands/calibration_test.cpp.
#include "apps/files/camera.h"

#include <gmock/gmock.h>

#include <tuple>
#include <vector>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

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
};

TEST_F(CalibrationFiles, WhatIsMissingOrWrongIsNamed) {
  for (const auto& [place, value, named] : std::vector<std::tuple<const char*, Json, const char*>>{
           {"/mm_per_px", 0.1, "no complaint"},
           {"/mm_per_px", 0, "greater than 0"},
           {"/distortion", Json::object(), "`distortion."},
           {"/width_px", 320.5, "`width_px` must be a whole number"},
           {"/width_px", 1LL << 40, "`width_px`"},
           {"/camera_matrix", {{1, 2}}, "`camera_matrix[1]` is missing"},
           {"/camera_matrix/0/0", "wide", "`camera_matrix[0][0]` must be a number"},
           {"/plane/rotation/0", {0, 0, 0}, "`plane.rotation` must be a rotation"},
           {"", Json::array(), "must hold an object"}}) {
    Json json = whole();
    json[Json::json_pointer(place)] = value;
    put(in_folder("c.json"), text_of(json));
    EXPECT_THAT(complaint_of([&] { read_calibration(in_folder("c.json")); }), testing::HasSubstr(named));
  }
}

}  // namespace
}  // namespace tribotrack::apps
