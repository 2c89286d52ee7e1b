#include "vision/layers/learning/lighting.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr double kRests = 0.3;                  ///< px: ground that moves less
constexpr double kSeenAlike = 0.25;             ///< of the windows see the same ground beside the disc
constexpr std::size_t kMostDisplacements = 24;  ///< over which the ground's light is averaged

/// What the camera has seen there, pixel by pixel.
Picture as_filmed(const KeptWindow& w, const StaticIllumination& light) {
  Picture out(w.picture.width(), w.picture.height());
  as_seen(w, 0, 0, out.width(), out.height(), out.levels().data());
  light.put_in(out, w.x, w.y);
  return out;
}

void change(KeptWindow& w, const StaticIllumination& from, const StaticIllumination& to) {
  Picture seen = as_filmed(w, from);
  w.picture = seen;
  to.take_out(seen, w.x, w.y, false);
  w.spline = QuinticSpline(seen);
  to.take_out(w.picture, w.x, w.y, true);
  w.partly_unseen = std::ranges::any_of(w.picture.levels(), StaticIllumination::unseen);
}

}  // namespace

bool LayeredLighting::learn(std::span<KeptWindow> windows, const LayeredDisc& disc, GroundPicture& ground,
                            const NoiseLaw& noise) {
  double away = 0;
  for (const KeptWindow& w : windows)
    away = std::max(away, std::hypot(w.state.ground.x - windows.front().state.ground.x,
                                     w.state.ground.y - windows.front().state.ground.y));
  const double alike = away > kRests ? kSeenAlike * static_cast<double>(windows.size()) : 0;
  LightLearning learning(disc, ground, noise, light_, !found(), alike);
  for (const KeptWindow& w : windows) learning.add(w);
  LightLearning::Learnt learnt = learning.solve();
  if (learnt.covariance.empty()) return false;
  learnt_from_.clear();
  for (const KeptWindow& w : windows) learnt_from_.push_back(w.state.centre);
  std::vector<Point> displacements;
  const std::size_t stride = windows.size() / kMostDisplacements + 1;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    change(windows[k], light_, learnt.light);
    if (k % stride == 0) displacements.push_back(windows[k].state.ground);
  }
  light_ = std::move(learnt.light);
  covariance_ = std::move(learnt.covariance);
  ground.set_light(light_, displacements);
  ground.finish(noise.at(ground.mean()));
  return true;
}

const Eigen::Matrix2d& LayeredLighting::covariance(const Point& centre) const {
  const auto square = [&](const Point& p) {
    return std::pow(p.x - centre.x, 2) + std::pow(p.y - centre.y, 2);
  };
  const auto nearest = std::ranges::min_element(learnt_from_, {}, square);
  return covariance_[static_cast<std::size_t>(nearest - learnt_from_.begin())];
}

}  // namespace tribotrack::vision
