#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "vision/synthesis/disc.h"
#include "vision/synthesis/texture.h"

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

namespace {

constexpr double kTolerance = 5e-5;  // of the contrast of an edge, per integral

std::vector<double> grid_of_points(int pixels, const QuadratureRule& rule) {
  std::vector<double> places;
  for (int i = 0; i < pixels; ++i) {
    for (const double node : rule.nodes) places.push_back(i + node);
  }
  return places;
}

QuadratureRule rule_for_edge_pixels(const Scene& scene, const PlatformTexture& texture) {
  return gauss_legendre(std::max(gauss_points_for_edge(scene.disc.edge_blur_px, kTolerance),
                                 gauss_points_for_wave(texture.max_wave_number(), kTolerance)));
}

void fill(PixelSpan span, float value, std::span<float> row) {
  for (int x = span.first; x <= span.last; ++x) row[x] = value;
}

void mark(const RowBand& band, std::vector<char>& edges) {
  for (int x = band.touched.first; x <= band.touched.last; ++x) edges[x] = 1;
  for (int x = band.filled.first; x <= band.filled.last; ++x) edges[x] = 0;
}

}  // namespace

struct SceneRenderer::Implementation {
  explicit Implementation(const Scene& s);

  /// One exposure: its poses and the places of what moves.
  struct Frame {
    std::vector<ExposureNode> nodes;
    std::vector<Point> discs;
    std::vector<double> cosines, sines;  // of theta
    std::vector<Point> markers;
  };
  /// A line of points across the picture at one time of the exposure.
  struct SubRow {
    double y;
    const Frame& frame;
    std::size_t node;
    const Eigen::VectorXf& texture;
  };
  Frame expose(double time_s, double exposure_s, const std::function<ScenePose(double)>& pose) const;

  void render_platform(const Frame& frame, Picture& picture) const;
  void render_filled(const Frame& frame, Picture& picture) const;
  void render_edges(const Frame& frame, Picture& picture) const;
  void find_edges(const Frame& frame, int y, std::vector<char>& edges) const;
  double scene_at(double x, int texture_column, const SubRow& row) const;
  void apply_light(double time_s, double exposure_s, double lamp_on_share, Picture& picture) const;

  Scene scene;
  BlurredCircle lamp_edge;
  DiscLayer disc;
  PlatformTexture texture;
  std::optional<MarkerLayer> marker;
  QuadratureRule rule;         // of the pixels with an edge in them
  TextureGrid texture_pixels;  // whole pixels
  TextureGrid texture_points;  // the rule's points in every pixel
  SceneCamera camera;
  Picture lamp_share;  // of each pixel; empty without lamp
};

SceneRenderer::Implementation::Implementation(const Scene& s)
    : scene(s),
      lamp_edge{s.lamp ? s.lamp->radius_px : 0, s.disc.edge_blur_px},
      disc(s.disc, s.seed),
      texture(s.platform, s.seed),
      rule(rule_for_edge_pixels(s, texture)),
      texture_pixels(texture, grid_of_points(s.width, gauss_legendre(1)),
                     grid_of_points(s.height, gauss_legendre(1)), TextureGrid::Value::kPixelMean),
      texture_points(texture, grid_of_points(s.width, rule), grid_of_points(s.height, rule),
                     TextureGrid::Value::kAtPoint),
      camera(s) {
  if (s.marker) marker.emplace(*s.marker, s.disc.edge_blur_px);
  if (!s.lamp) return;
  lamp_share = Picture(s.width, s.height);
  for (int y = 0; y < s.height; ++y) {
    const RowBand band = row_band(lamp_edge, {&s.lamp->position, 1}, y, s.width);
    for (int x = band.touched.first; x <= band.touched.last; ++x) {
      double share = 0;
      for (std::size_t j = 0; j < rule.nodes.size(); ++j) {
        for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
          share += rule.weights[i] * rule.weights[j] *
                   lamp_edge.coverage(x + rule.nodes[i] - s.lamp->position.x,
                                      y + rule.nodes[j] - s.lamp->position.y);
        }
      }
      lamp_share.at(x, y) = static_cast<float>(share);
    }
  }
}

SceneRenderer::Implementation::Frame SceneRenderer::Implementation::expose(
    double time_s, double exposure_s, const std::function<ScenePose(double)>& pose) const {
  Frame frame;
  frame.nodes = exposure_nodes(time_s, exposure_s, pose, scene.disc.visible ? scene.disc.radius_px : 0,
                               scene.disc.edge_blur_px, texture.max_wave_number(), kTolerance);
  for (const ExposureNode& node : frame.nodes) {
    frame.discs.push_back(node.pose.disc);
    frame.cosines.push_back(std::cos(node.pose.theta));
    frame.sines.push_back(std::sin(node.pose.theta));
    if (scene.marker) {
      frame.markers.push_back(
          {scene.marker->position.x + node.pose.platform.x, scene.marker->position.y + node.pose.platform.y});
    }
  }
  return frame;
}

void SceneRenderer::Implementation::render_platform(const Frame& frame, Picture& picture) const {
  std::ranges::fill(picture.levels(), static_cast<float>(scene.platform.level));
  texture_pixels.add_to(picture, texture_pixels.coefficients(frame.nodes));
}

void SceneRenderer::Implementation::render_filled(const Frame& frame, Picture& picture) const {
  if (marker) {
    for (int y = 0; y < scene.height; ++y) {
      fill(row_band(marker->ring, frame.markers, y, scene.width).filled,
           static_cast<float>(marker->look.ring_level), picture.row(y));
      fill(row_band(marker->dot, frame.markers, y, scene.width).filled,
           static_cast<float>(marker->look.level), picture.row(y));
    }
  }
  if (scene.disc.visible) {
    std::vector<PixelSpan> filled;
    for (int y = 0; y < scene.height; ++y) {
      filled.push_back(row_band(disc.edge(), frame.discs, y, scene.width).filled);
    }
    disc.render_interior(frame.nodes, filled, picture);
  }
  if (scene.lamp) {
    for (int y = 0; y < scene.height; ++y) {
      fill(row_band(lamp_edge, {&scene.lamp->position, 1}, y, scene.width).filled, 0, picture.row(y));
    }
  }
}

/// Pixels of the row with an edge in them that no layer above hides.
void SceneRenderer::Implementation::find_edges(const Frame& frame, int y, std::vector<char>& edges) const {
  std::ranges::fill(edges, 0);
  if (marker) {
    mark(row_band(marker->ring, frame.markers, y, scene.width), edges);
    mark(row_band(marker->dot, frame.markers, y, scene.width), edges);
  }
  if (scene.disc.visible) mark(row_band(disc.edge(), frame.discs, y, scene.width), edges);
  if (scene.lamp) mark(row_band(lamp_edge, {&scene.lamp->position, 1}, y, scene.width), edges);
}

/// Mean over pixel and exposure of (1 - lamp) [disc over marker over platform], by the rule's points.
void SceneRenderer::Implementation::render_edges(const Frame& frame, Picture& picture) const {
  const int points = static_cast<int>(rule.nodes.size());
  std::vector<TextureGrid::Coefficients> waves;
  for (const ExposureNode& node : frame.nodes) {
    const ExposureNode alone{1.0, node.pose};
    waves.push_back(texture_points.coefficients({&alone, 1}));
  }
  std::vector<char> edges(scene.width);
  std::vector<double> sums(scene.width);
  Eigen::VectorXf texture_row;
  for (int y = 0; y < scene.height; ++y) {
    find_edges(frame, y, edges);
    const auto first = static_cast<int>(std::ranges::find(edges, 1) - edges.begin());
    if (first == scene.width) continue;
    std::ranges::fill(sums, 0.0);
    for (std::size_t k = 0; k < frame.nodes.size(); ++k) {
      for (int j = 0; j < points; ++j) {
        texture_points.prepare_row(waves[k], y * points + j, texture_row);
        const SubRow row{y + rule.nodes[j], frame, k, texture_row};
        const double weight = frame.nodes[k].weight * rule.weights[j];
        for (int x = first; x < scene.width; ++x) {
          if (edges[x] == 0) continue;
          for (int i = 0; i < points; ++i) {
            sums[x] += weight * rule.weights[i] * scene_at(x + rule.nodes[i], x * points + i, row);
          }
        }
      }
    }
    for (int x = first; x < scene.width; ++x) {
      if (edges[x] != 0) picture.at(x, y) = static_cast<float>(sums[x]);
    }
  }
}

double SceneRenderer::Implementation::scene_at(double x, int texture_column, const SubRow& row) const {
  double left = 1;  // for the layers below
  double level = 0;
  const auto lay = [&](const BlurredCircle& edge, const Point& at, const auto& colour) {
    const double dx = x - at.x, dy = row.y - at.y, cover = left > 0 ? edge.coverage(dx, dy) : 0;
    if (cover <= 0) return;
    level += left * cover * colour(dx, dy);
    left *= 1 - cover;
  };
  if (scene.lamp) lay(lamp_edge, scene.lamp->position, [](double, double) { return 0; });
  if (scene.disc.visible)
    lay(disc.edge(), row.frame.discs[row.node], [&](double dx, double dy) {
      return disc.colour(dx, dy, row.frame.cosines[row.node], row.frame.sines[row.node]);
    });
  if (marker)
    lay(marker->ring, row.frame.markers[row.node],
        [&](double dx, double dy) { return marker->colour(dx, dy); });
  return left > 0 ? level + left * (scene.platform.level + texture_points.at(row.texture, texture_column))
                  : level;
}

/// The light falling on the scene, and the lamp's own.
void SceneRenderer::Implementation::apply_light(double time_s, double exposure_s, double lamp_on_share,
                                                Picture& picture) const {
  const auto flicker = static_cast<float>(camera.flicker(time_s, exposure_s));
  for (float& level : picture.levels()) level *= flicker;
  if (!scene.lamp) return;
  const auto lamp_level = static_cast<float>(scene.lamp->off_level +
                                             lamp_on_share * (scene.lamp->on_level - scene.lamp->off_level));
  for (std::size_t i = 0; i < picture.levels().size(); ++i) {
    picture.levels()[i] += lamp_level * lamp_share.levels()[i];
  }
}

SceneRenderer::SceneRenderer(const Scene& scene) {
  scene.validate();
  implementation_ = std::make_shared<Implementation>(scene);
}

const Scene& SceneRenderer::scene() const {
  return implementation_->scene;
}

Picture SceneRenderer::render_exact(double time_s, double exposure_s,
                                    const std::function<ScenePose(double)>& pose,
                                    double lamp_on_share) const {
  const Implementation& im = *implementation_;
  if (!(lamp_on_share >= 0 && lamp_on_share <= 1)) {
    throw std::invalid_argument("lamp_on_share must be between 0 and 1");
  }
  const Implementation::Frame frame = im.expose(time_s, exposure_s, pose);
  Picture picture(im.scene.width, im.scene.height);
  im.render_platform(frame, picture);
  im.render_filled(frame, picture);
  im.render_edges(frame, picture);
  im.apply_light(time_s, exposure_s, lamp_on_share, picture);
  im.camera.to_levels(picture);
  return picture;
}

Picture SceneRenderer::render(std::int64_t index, double time_s, double exposure_s,
                              const std::function<ScenePose(double)>& pose, double lamp_on_share) const {
  Picture picture = render_exact(time_s, exposure_s, pose, lamp_on_share);
  implementation_->camera.record(picture, index);
  return picture;
}

}  // namespace tribotrack::vision
