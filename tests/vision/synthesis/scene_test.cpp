#include "vision/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace tribotrack::vision {
namespace {

TEST(Scene, TheDefaultsAreValid) {
  Scene scene;
  scene.marker.emplace();
  scene.lamp.emplace();
  EXPECT_NO_THROW(scene.validate());
}

TEST(Scene, ValidationNamesTheKeyAndTheValue) {
  const std::vector<std::pair<std::string, std::function<void(Scene&)>>> cases{
      {"width must be 1 to 16384, not 0", [](Scene& s) { s.width = 0; }},
      {"bits", [](Scene& s) { s.bits = 7; }},
      {"disc.radius_px must be a positive number, not -3", [](Scene& s) { s.disc.radius_px = -3; }},
      {"disc.edge_blur_px must be at least 0.1", [](Scene& s) { s.disc.edge_blur_px = 0; }},
      {"disc.highlight", [](Scene& s) { s.disc.highlight = NAN; }},
      {"platform.texture_rms", [](Scene& s) { s.platform.texture_rms = -1; }},
      {"marker.position", [](Scene& s) { s.marker.emplace().position.y = NAN; }},
      {"lamp.on_level", [](Scene& s) { s.lamp.emplace().on_level = NAN; }},
      {"vignetting", [](Scene& s) { s.vignetting = 1; }},
      {"flicker must", [](Scene& s) { s.flicker = -0.1; }},
  };
  for (const auto& [text, spoil] : cases) {
    Scene scene;
    spoil(scene);
    try {
      SceneRenderer renderer(scene);
      ADD_FAILURE() << text << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(text));
    }
  }
}

}  // namespace
}  // namespace tribotrack::vision
