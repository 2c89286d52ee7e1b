#include "vision/scene.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace tribotrack::vision {
namespace {

void require(bool good, const std::string& key, double value, const std::string& wanted) {
  if (good) return;
  std::ostringstream text;
  text << "scene: " << key << " must be " << wanted << ", not " << value;
  throw std::invalid_argument(text.str());
}

void require_finite(const std::string& key, double value) {
  require(std::isfinite(value), key, value, "a finite number");
}

void require_positive(const std::string& key, double value) {
  require(std::isfinite(value) && value > 0, key, value, "a positive number");
}

void require_not_negative(const std::string& key, double value) {
  require(std::isfinite(value) && value >= 0, key, value, "zero or a positive number");
}

}  // namespace

void Scene::validate() const {
  require(width >= 1 && width <= 16384, "width", width, "1 to 16384");
  require(height >= 1 && height <= 16384, "height", height, "1 to 16384");
  require(bits >= 8 && bits <= 16, "bits", bits, "8 to 16");

  require_positive("disc.radius_px", disc.radius_px);
  require_not_negative("disc.level", disc.level);
  require(std::isfinite(disc.edge_blur_px) && disc.edge_blur_px >= 0.1, "disc.edge_blur_px",
          disc.edge_blur_px, "at least 0.1");
  require(disc.scratches >= 0 && disc.scratches <= 10000, "disc.scratches", disc.scratches, "0 to 10000");
  require_finite("disc.scratch_contrast", disc.scratch_contrast);
  require_finite("disc.highlight", disc.highlight);

  require_not_negative("platform.level", platform.level);
  require_not_negative("platform.texture_rms", platform.texture_rms);
  require_finite("platform.brush_angle_rad", platform.brush_angle_rad);
  require(std::isfinite(platform.texture_length_px) && platform.texture_length_px >= 0.5,
          "platform.texture_length_px", platform.texture_length_px, "at least 0.5");
  require(std::isfinite(platform.texture_width_px) && platform.texture_width_px >= 0.5,
          "platform.texture_width_px", platform.texture_width_px, "at least 0.5");

  if (marker) {
    require_finite("marker.position x", marker->position.x);
    require_finite("marker.position y", marker->position.y);
    require_positive("marker.radius_px", marker->radius_px);
    require_not_negative("marker.level", marker->level);
    require_not_negative("marker.ring_level", marker->ring_level);
  }
  if (lamp) {
    require_finite("lamp.position x", lamp->position.x);
    require_finite("lamp.position y", lamp->position.y);
    require_positive("lamp.radius_px", lamp->radius_px);
    require_not_negative("lamp.on_level", lamp->on_level);
    require_not_negative("lamp.off_level", lamp->off_level);
  }
  require(vignetting >= 0 && vignetting < 1, "vignetting", vignetting, "at least 0 and below 1");
  require(flicker >= 0 && flicker <= 1, "flicker", flicker, "between 0 and 1");
  require_not_negative("flicker_hz", flicker_hz);
  require_not_negative("read_noise", read_noise);
  require_not_negative("shot_noise", shot_noise);
}

}  // namespace tribotrack::vision
