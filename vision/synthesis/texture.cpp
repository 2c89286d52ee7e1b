// The brushed platform of a synthetic scene, and what the light of a scene allows to be known of a position.
#include "vision/synthesis/texture.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "vision/cramer_rao_bound.h"

namespace tribotrack::vision {
namespace {

constexpr int kWaves = 48;
constexpr double kPi = std::numbers::pi;

/// sin(k/2) / (k/2): what a pixel's width leaves of a wave.
double pixel_response(double k) {
  return std::abs(k) < 1e-8 ? 1.0 : std::sin(k / 2) / (k / 2);
}

}  // namespace

PlatformTexture::PlatformTexture(const PlatformAppearance& platform, std::uint64_t seed) {
  if (platform.texture_rms <= 0) return;
  const CounterRandom random(seed, 0x7e47u);
  // The brush direction in pixels, y down.
  const double cosine = std::cos(platform.brush_angle_rad);
  const double sine = -std::sin(platform.brush_angle_rad);
  std::vector<int> order(kWaves);
  std::iota(order.begin(), order.end(), 0);
  for (int w = kWaves - 1; w > 0; --w) {
    std::swap(order[w], order[static_cast<int>(random.uniform(1000 + w) * (w + 1))]);
  }
  for (int w = 0; w < kWaves; ++w) {
    const double along = normal_quantile((w + random.uniform(4 * w)) / kWaves) / platform.texture_length_px;
    const double across =
        normal_quantile((order[w] + random.uniform(4 * w + 1)) / kWaves) / platform.texture_width_px;
    Wave wave;
    wave.kx = along * cosine - across * sine;
    wave.ky = along * sine + across * cosine;
    wave.phase = 2 * kPi * random.uniform(4 * w + 2);
    wave.amplitude = platform.texture_rms * std::sqrt(2.0 / kWaves);
    waves_.push_back(wave);
  }
}

double PlatformTexture::max_wave_number() const {
  double largest = 0;
  for (const Wave& wave : waves_) largest = std::max({largest, std::abs(wave.kx), std::abs(wave.ky)});
  return largest;
}

TextureGrid::TextureGrid(const PlatformTexture& texture, std::span<const double> xs,
                         std::span<const double> ys, Value value)
    : waves_(texture.waves()) {
  const auto waves = static_cast<Eigen::Index>(waves_.size());
  columns_.resize(2 * waves, static_cast<Eigen::Index>(xs.size()));
  rows_.resize(waves, static_cast<Eigen::Index>(ys.size()));
  for (Eigen::Index w = 0; w < waves; ++w) {
    PlatformTexture::Wave& wave = waves_[w];
    if (value == Value::kPixelMean) wave.amplitude *= pixel_response(wave.kx) * pixel_response(wave.ky);
    for (Eigen::Index i = 0; i < columns_.cols(); ++i) {
      columns_(w, i) = static_cast<float>(std::cos(wave.kx * xs[i]));
      columns_(waves + w, i) = static_cast<float>(std::sin(wave.kx * xs[i]));
    }
    for (Eigen::Index i = 0; i < rows_.cols(); ++i) rows_(w, i) = std::polar(1.0, wave.ky * ys[i]);
  }
}

TextureGrid::Coefficients TextureGrid::coefficients(std::span<const ExposureNode> nodes) const {
  Coefficients result;
  result.reserve(waves_.size());
  for (const PlatformTexture::Wave& wave : waves_) {
    std::complex<double> sum = 0;
    for (const ExposureNode& node : nodes) {
      const Point& moved = node.pose.platform;
      sum += std::polar(node.weight, wave.phase - wave.kx * moved.x - wave.ky * moved.y);
    }
    result.push_back(wave.amplitude * sum);
  }
  return result;
}

void TextureGrid::prepare_row(const Coefficients& coefficients, int iy, Eigen::VectorXf& row) const {
  const auto waves = static_cast<Eigen::Index>(waves_.size());
  row.resize(2 * waves);
  for (Eigen::Index w = 0; w < waves; ++w) {
    const std::complex<double> c = coefficients[w];
    const std::complex<double> e = rows_(w, iy);
    row(w) = static_cast<float>(c.real() * e.real() - c.imag() * e.imag());
    row(waves + w) = static_cast<float>(-(c.real() * e.imag() + c.imag() * e.real()));
  }
}

void TextureGrid::add_to(Picture& picture, const Coefficients& coefficients) const {
  if (empty()) return;
  Eigen::MatrixXf rows(columns_.rows(), rows_.cols());
  Eigen::VectorXf row;
  for (Eigen::Index y = 0; y < rows.cols(); ++y) {
    prepare_row(coefficients, static_cast<int>(y), row);
    rows.col(y) = row;
  }
  // Re(c e^{i kx x} e^{i ky y}) summed over the waves: one real matrix product for the whole picture.
  Eigen::Map<Eigen::MatrixXf> levels(picture.levels().data(), picture.width(), picture.height());
  levels.noalias() += columns_.transpose() * rows;
}

namespace {

/// dI/dx or dI/dy by differences of sixth order: (45 f1 - 9 f2 + f3) / (60 h), f_n = f(n h) - f(-n h).
Picture slope(const SceneRenderer& renderer, double time_s, double exposure_s,
              const std::function<ScenePose(double)>& pose, double lamp_on_share, Point direction) {
  constexpr double h = 0.25;  // px: against edges of 0.5 px and more neither truncation nor floats matter
  constexpr std::array<double, 3> weights{45, -9, 1};
  const auto shifted = [&](double by) {
    const auto moved = [&](double t) {
      ScenePose p = pose(t);
      p.disc.x += by * direction.x;
      p.disc.y += by * direction.y;
      return p;
    };
    return renderer.render_exact(time_s, exposure_s, moved, lamp_on_share);
  };
  Picture result(renderer.scene().width, renderer.scene().height);
  for (int n = 1; n <= 3; ++n) {
    const Picture ahead = shifted(n * h);
    const Picture behind = shifted(-n * h);
    const auto weight = static_cast<float>(weights[n - 1] / (60 * h));
    for (std::size_t i = 0; i < result.levels().size(); ++i) {
      result.levels()[i] += weight * (ahead.levels()[i] - behind.levels()[i]);
    }
  }
  return result;
}

}  // namespace

Eigen::Matrix2d position_bound(const SceneRenderer& renderer, double time_s, double exposure_s,
                               const std::function<ScenePose(double)>& pose, double lamp_on_share) {
  const Scene& scene = renderer.scene();
  const double scale = std::ldexp(1.0, scene.bits - 8);
  const double top = std::ldexp(1.0, scene.bits) - 1;
  const Picture level = renderer.render_exact(time_s, exposure_s, pose, lamp_on_share);
  const Picture slope_x = slope(renderer, time_s, exposure_s, pose, lamp_on_share, {1, 0});
  const Picture slope_y = slope(renderer, time_s, exposure_s, pose, lamp_on_share, {0, 1});

  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < level.levels().size(); ++i) {
    const double mean = level.levels()[i];
    if (mean < 0 || mean > top) continue;
    const double variance =
        (scene.read_noise * scene.read_noise + scene.shot_noise * mean / scale) * scale * scale + 1.0 / 12;
    const Eigen::Vector2d gradient(slope_x.levels()[i], slope_y.levels()[i]);
    information += gradient * gradient.transpose() / variance;
  }
  if (!(information.determinant() > 1e-12 * information.squaredNorm())) {
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()).asDiagonal();
  }
  return information.inverse();
}

}  // namespace tribotrack::vision
