#include "vision/layers/standing_light.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr double kSmooth = 3;    ///< px: the least width of a light that is learnt at once
constexpr float kHalfKnown = 1;  ///< frames: a place seen less often is held to no light
constexpr double kFewest = 3;    ///< frames that tell what changes at a pixel

/// A Gaussian, both ways.
Picture blurred(const Picture& in) {
  const int reach = static_cast<int>(std::ceil(3 * kSmooth));
  std::vector<float> weight;
  float total = 0;
  for (int i = -reach; i <= reach; ++i) {
    weight.push_back(static_cast<float>(std::exp(-0.5 * i * i / (kSmooth * kSmooth))));
    total += weight.back();
  }
  Picture rows(in.width(), in.height()), out(in.width(), in.height());
  const auto at = [&](int i) { return weight[static_cast<std::size_t>(i + reach)] / total; };
  for (int y = 0; y < in.height(); ++y)
    for (int x = 0; x < in.width(); ++x)
      for (int i = std::max(-reach, -x); i <= std::min(reach, in.width() - 1 - x); ++i)
        rows.at(x, y) += at(i) * in.at(x + i, y);
  for (int y = 0; y < in.height(); ++y)
    for (int j = std::max(-reach, -y); j <= std::min(reach, in.height() - 1 - y); ++j)
      for (int x = 0; x < in.width(); ++x) out.at(x, y) += at(j) * rows.at(x, y + j);
  return out;
}

/// Pixels of the camera about a centre, as far as they lie in a window of this size.
Rect about(const Point& centre, double reach, int x, int y, const Picture& window) {
  const int x0 = std::max(x, static_cast<int>(std::ceil(centre.x - reach))),
            y0 = std::max(y, static_cast<int>(std::ceil(centre.y - reach)));
  const int x1 = std::min(x + window.width() - 1, static_cast<int>(std::floor(centre.x + reach))),
            y1 = std::min(y + window.height() - 1, static_cast<int>(std::floor(centre.y + reach)));
  return {x0, y0, std::max(0, x1 - x0 + 1), std::max(0, y1 - y0 + 1)};
}

}  // namespace

StandingLight::StandingLight(const Rect& region, const Picture& share)
    : region_(region), half_(share.width() / 2), share_(share), level_(region.width, region.height) {}

void StandingLight::learn(std::vector<KeptWindow>& windows, const std::vector<bool>& explained,
                          const PartPictures& part, double inside) {
  Picture sum(region_.width, region_.height), squares = sum, count = sum;
  const QuinticSpline level(part.level);
  std::vector<float> shown;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    if (!explained[k]) continue;
    const KeptWindow& w = windows[k];
    const LayeredState& s = w.state;
    const Rect face = about(s.centre, inside, w.x, w.y, w.picture);
    if (face.width == 0 || face.height == 0) continue;
    shown.resize(static_cast<std::size_t>(face.width) * static_cast<std::size_t>(face.height));
    const double u0 = face.x - s.centre.x, v0 = face.y - s.centre.y;
    level.sample_window(u0 + part.half, v0 + part.half, face.width, face.height, shown.data(), nullptr,
                        nullptr);
    for (int j = 0; j < face.height; ++j)
      for (int i = 0; i < face.width; ++i) {
        const double u = u0 + i, v = v0 + j;
        const int x = face.x + i - region_.x, y = face.y + j - region_.y;
        if (u * u + v * v > inside * inside || x < 0 || y < 0 || x >= region_.width || y >= region_.height)
          continue;
        const auto gain = static_cast<float>(s.gain * (1 + s.slope_x * u + s.slope_y * v));
        const float left = w.picture.at(face.x + i - w.x, face.y + j - w.y) -
                           gain * shown[static_cast<std::size_t>(j) * static_cast<std::size_t>(face.width) +
                                        static_cast<std::size_t>(i)];
        sum.at(x, y) += left;
        squares.at(x, y) += left * left;
        count.at(x, y) += 1;
      }
  }
  double between = 0, places = 0, within = 0, frames = 0;
  for (std::size_t i = 0; i < sum.levels().size(); ++i) {
    const double n = count.levels()[i];
    if (n < kFewest) continue;
    const double stands = static_cast<double>(sum.levels()[i]) * sum.levels()[i] / n;
    between += stands;
    within += squares.levels()[i] - stands;
    ++places;
    frames += n - 1;
  }
  evidence_ = within > 0 ? (between / places) / (within / frames) : 1;
  const Picture smooth_sum = blurred(sum), smooth_count = blurred(count);
  Picture more(region_.width, region_.height);
  for (std::size_t i = 0; i < more.levels().size(); ++i) {
    more.levels()[i] = smooth_sum.levels()[i] / (smooth_count.levels()[i] + kHalfKnown);
    level_.levels()[i] += more.levels()[i];
  }
  for (KeptWindow& w : windows) {
    take_out(more, w.picture, w.x, w.y, w.state.centre);
    w.spline = QuinticSpline(w.picture);
  }
}

void StandingLight::take_out(const Picture& light, Picture& picture, int x, int y,
                             const Point& centre) const {
  const Rect grid = about(centre, half_ - 2, x, y, picture);
  if (grid.width == 0 || grid.height == 0) return;
  std::vector<float> ground(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  share_.sample_window(grid.x - centre.x + half_, grid.y - centre.y + half_, grid.width, grid.height,
                       ground.data(), nullptr, nullptr);
  for (int j = 0; j < grid.height; ++j)
    for (int i = 0; i < grid.width; ++i) {
      const int at_x = grid.x + i - region_.x, at_y = grid.y + j - region_.y;
      if (at_x < 0 || at_y < 0 || at_x >= region_.width || at_y >= region_.height) continue;
      const float covers = 1 - ground[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.width) +
                                      static_cast<std::size_t>(i)];
      picture.at(grid.x + i - x, grid.y + j - y) -= covers * light.at(at_x, at_y);
    }
}

}  // namespace tribotrack::vision
