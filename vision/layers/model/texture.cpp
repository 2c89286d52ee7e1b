#include "vision/layers/model/texture.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr double kClear = 3;  ///< blurs of the rim that the texture keeps away from it
constexpr double kTaper = 2;  ///< px over which it ends

}  // namespace

TurningTexture::TurningTexture(int half, double radius, double blur, bool turned_round)
    : half_(half), turned_round_(turned_round), levels_(2 * half + 1, 2 * half + 1), spline_(levels_) {
  const double reach = turned_round ? radius + kClear * blur + kTaper : radius - kClear * blur;
  for (int j = -half; j <= half; ++j)
    for (int i = -half; i <= half; ++i) {
      const double t = std::clamp((reach - std::hypot(i, j)) / kTaper, 0.0, 1.0);
      face_.push_back(static_cast<float>(t * t * (3 - 2 * t)));
    }
}

/// The face's places turned by theta. Counter-clockwise with y up is, in pixels with y down,
/// (x, y) -> (c x + s y, -s x + c y).
TurningTexture::Places TurningTexture::face_turned(double theta) const {
  const auto c = static_cast<float>(std::cos(theta)), s = static_cast<float>(std::sin(theta));
  const auto middle = static_cast<float>(half_);
  const auto size = static_cast<std::size_t>(2 * half_ + 1);
  Places out;
  for (std::size_t k = 0; k < face_.size(); ++k) {
    if (!(face_[k] > 0)) continue;
    const float u = static_cast<float>(k % size) - middle, v = static_cast<float>(k / size) - middle;
    out.pixel.push_back(k);
    out.x.push_back(middle + c * u + s * v);
    out.y.push_back(middle - s * u + c * v);
  }
  return out;
}

void TurningTexture::learn(WindowSpan windows, const PartPictures& part, const GroundPicture& ground) {
  const QuinticSpline level(part.level), share(part.share);
  const auto mean = static_cast<float>(ground.mean());
  std::vector<float> sum(face_.size(), 0), weight(face_.size(), 0);
  std::vector<float> seen, shown, through, below, in_x, in_y, on_x, on_y;
  for (const KeptWindow* window : windows) {
    const KeptWindow& w = *window;
    const LayeredState& s = w.state;
    const Places places = face_turned(s.theta);
    const std::size_t n = places.pixel.size();
    for (auto* of : {&seen, &shown, &through, &below, &in_x, &in_y, &on_x, &on_y}) of->resize(n);
    const auto left = static_cast<float>(s.centre.x - half_ - w.x),
               top = static_cast<float>(s.centre.y - half_ - w.y);
    // On the ground's picture.
    const auto before_x = static_cast<float>(w.x - s.ground.x - ground.region().x),
               before_y = static_cast<float>(w.y - s.ground.y - ground.region().y);
    for (std::size_t i = 0; i < n; ++i) {
      in_x[i] = places.x[i] + left;
      in_y[i] = places.y[i] + top;
      on_x[i] = in_x[i] + before_x;
      on_y[i] = in_y[i] + before_y;
    }
    w.spline.sample_places(in_x, in_y, seen.data(), nullptr, nullptr);
    level.sample_places(places.x, places.y, shown.data(), nullptr, nullptr);
    share.sample_places(places.x, places.y, through.data(), nullptr, nullptr);
    ground.spline().sample_places(on_x, on_y, below.data(), nullptr, nullptr);
    const auto gain = static_cast<float>(s.gain), slope_x = static_cast<float>(s.gain * s.slope_x),
               slope_y = static_cast<float>(s.gain * s.slope_y);
    const auto middle = static_cast<float>(half_), under = static_cast<float>(s.ground_gain);
    for (std::size_t i = 0; i < n; ++i) {
      const bool inside = in_x[i] >= 0 && in_y[i] >= 0 &&
                          in_x[i] <= static_cast<float>(w.picture.width() - 1) &&
                          in_y[i] <= static_cast<float>(w.picture.height() - 1);
      if (!inside) continue;
      const float a = gain + slope_x * (places.x[i] - middle) + slope_y * (places.y[i] - middle);
      const std::size_t at = places.pixel[i];
      sum[at] += a * (seen[i] - a * (shown[i] - through[i] * mean) - under * through[i] * (below[i] + mean));
      weight[at] += a * a;
    }
  }
  for (std::size_t at = 0; at < face_.size(); ++at)
    levels_.levels()[at] = weight[at] > 0 ? face_[at] * sum[at] / weight[at] : 0;
  take_out_rings();
  spline_ = QuinticSpline(levels_);
}

/// Of every ring, a pixel wide, what others may claim: its mean and, of a part that has not turned right
/// round, its first harmonic.
void TurningTexture::take_out_rings() {
  const auto size = static_cast<std::size_t>(2 * half_ + 1);
  std::vector<Eigen::Vector3d> sum(2 * static_cast<std::size_t>(half_) + 2, Eigen::Vector3d::Zero());
  std::vector<double> count(sum.size(), 0);
  const auto each = [&](const auto& act) {
    for (std::size_t at = 0; at < face_.size(); ++at) {
      if (!(face_[at] > 0)) continue;
      const double u = static_cast<double>(at % size) - half_, v = static_cast<double>(at / size) - half_;
      const double rho = std::max(0.5, std::hypot(u, v));
      const Eigen::Vector3d wave(1, u / rho, v / rho);
      act(at, static_cast<std::size_t>(std::lround(rho)), wave);
    }
  };
  each([&](std::size_t at, std::size_t ring, const Eigen::Vector3d& wave) {
    sum[ring] += static_cast<double>(levels_.levels()[at]) * wave;
    count[ring] += static_cast<double>(face_[at]);
  });
  each([&](std::size_t at, std::size_t ring, const Eigen::Vector3d& wave) {
    Eigen::Vector3d mean = sum[ring] / count[ring];
    mean.tail<2>() *= turned_round_ ? 0 : 2;
    levels_.levels()[at] -= face_[at] * static_cast<float>(mean.dot(wave));
  });
}

Picture TurningTexture::at(double theta, Picture* slope) const {
  const int size = 2 * half_ + 1;
  Picture out(size, size);
  if (slope) *slope = Picture(size, size);
  const Places places = face_turned(-theta);
  const std::size_t n = places.pixel.size();
  std::vector<float> value(n), slope_x(n), slope_y(n);
  spline_.sample_places(places.x, places.y, value.data(), slope ? slope_x.data() : nullptr,
                        slope ? slope_y.data() : nullptr);
  const auto middle = static_cast<float>(half_);
  for (std::size_t i = 0; i < n; ++i) {
    out.levels()[places.pixel[i]] = value[i];
    // d/dtheta of R(-theta) u is (-(y'), x') turned back: with y down, (x', y') -> (-y', x').
    if (slope)
      slope->levels()[places.pixel[i]] =
          slope_y[i] * (places.x[i] - middle) - slope_x[i] * (places.y[i] - middle);
  }
  return out;
}

double TurningTexture::contrast() const {
  double square = 0, n = 0;
  for (std::size_t at = 0; at < face_.size(); ++at)
    if (face_[at] > 0) {
      square += std::pow(static_cast<double>(levels_.levels()[at]), 2);
      ++n;
    }
  return n > 0 ? std::sqrt(square / n) : 0;
}

}  // namespace tribotrack::vision
