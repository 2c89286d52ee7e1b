// The even middle of the disc in the registration: what it tells of the light, and where it is not even, of
// the centre.
#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/layers/registration/registration.h"

namespace tribotrack::vision {
namespace {

constexpr double kSloping = 2;  ///< times the slope that noise alone makes
constexpr double kNothing = std::numeric_limits<double>::infinity();  ///< is trimmed

}  // namespace

/// With r = I - S(u) summed, the residual is r - q . column + gain grad S . shift.
Eigen::Vector3d LayeredRegistration::Plateau::force_at(const LayerLight& light,
                                                       const Eigen::Vector2d& shift) const {
  return force - normal * Eigen::Vector3d(light.gain - 1, light.slope_x, light.slope_y) +
         light.gain * (slope * shift);
}

/// The model's derivative by the centre is -gain grad S.
Eigen::Vector2d LayeredRegistration::Plateau::step_force_at(const LayerLight& light,
                                                            const Eigen::Vector2d& shift) const {
  const Eigen::Vector3d q(light.gain - 1, light.slope_x, light.slope_y);
  return -light.gain * (pull - slope.transpose() * q + light.gain * (steepness * shift));
}

double LayeredRegistration::Plateau::squares_at(const LayerLight& light, const Eigen::Vector2d& shift) const {
  const Eigen::Vector3d q(light.gain - 1, light.slope_x, light.slope_y);
  const Eigen::Vector2d moved = light.gain * shift;
  return squares - 2 * q.dot(force) + q.dot(normal * q) + 2 * moved.dot(pull - slope.transpose() * q) +
         moved.dot(steepness * moved);
}

void LayeredRegistration::Plateau::add(double weight, const Eigen::Vector3d& column,
                                       const Eigen::Vector2d& gradient) {
  normal += weight * column * column.transpose();
  slope += weight * column * gradient.transpose();
  steepness += weight * gradient * gradient.transpose();
  ++pixels;
}

/// grad S at whole pixels, where the middle slopes by more than the noise it was learnt with.
void LayeredRegistration::slope_of_middle() {
  const int size = plateau_weight_.width();
  slope_x_ = slope_y_ = Picture(size, size);
  double squares = 0, noise = 0;
  for (const Run& run : runs_)
    for (int i = run.first; i < run.first + run.count; ++i) {
      if (plateau_weight_.at(i, run.y) == 0) continue;
      const int left = std::max(i - 1, 0), right = std::min(i + 1, size - 1);
      const int above = std::max(run.y - 1, 0), below = std::min(run.y + 1, size - 1);
      const float x = 0.5F * (shown_.at(right, run.y) - shown_.at(left, run.y));
      const float y = 0.5F * (shown_.at(i, below) - shown_.at(i, above));
      slope_x_.at(i, run.y) = x;
      slope_y_.at(i, run.y) = y;
      squares += static_cast<double>(x * x + y * y);
      noise += noise_.at(shown_.at(i, run.y)) / frames_;
    }
  if (squares <= kSloping * noise) slope_x_ = slope_y_ = Picture();
}

Eigen::Vector2d LayeredRegistration::shown_slope(int i, int j) const {
  if (slope_x_.empty()) return Eigen::Vector2d::Zero();
  return {static_cast<double>(slope_x_.at(i, j)), static_cast<double>(slope_y_.at(i, j))};
}

void LayeredRegistration::make_plateau() {
  if (shown_.empty()) return;
  plateau_ = {};
  slope_of_middle();
  for (const Run& run : runs_)
    for (int i = run.first; i < run.first + run.count; ++i) {
      float& weight = plateau_weight_.at(i, run.y);
      if (weight == 0) continue;
      const double level = shown_.at(i, run.y);
      weight = static_cast<float>(1 / noise_.at(level));
      const Eigen::Vector3d column = level * Eigen::Vector3d(1, i - disc_.half(), run.y - disc_.half());
      plateau_.add(static_cast<double>(weight), column, shown_slope(i, run.y));
    }
}

LayeredRegistration::Plateau LayeredRegistration::take_plateau(const Picture& picture, int x, int y) const {
  Plateau out = plateau_;
  const int left = x0_ - disc_.half() - x, top = y0_ - disc_.half() - y;
  for (const Run& run : runs_) {
    const int px = left + run.first, py = top + run.y;
    if (px < 0 || py < 0 || px + run.count > picture.width() || py >= picture.height())
      return trimmed_plateau(picture, x, y, {}, Eigen::Vector2d::Zero(), kNothing);
    if (out_of_picture_ && std::ranges::any_of(picture.row(py).subspan(static_cast<std::size_t>(px),
                                                                       static_cast<std::size_t>(run.count)),
                                               StaticIllumination::unseen))
      return trimmed_plateau(picture, x, y, {}, Eigen::Vector2d::Zero(), kNothing);
    const auto first = static_cast<std::size_t>(run.first);
    const PlateauSums sums =
        layer_kernels_.plateau({picture.row(py).data() + px, shown_.row(run.y).data() + first,
                                plateau_weight_.row(run.y).data() + first, ramp_.data() + first, run.count});
    out.force += Eigen::Vector3d(sums[0], sums[1], (run.y - disc_.half()) * sums[0]);
    out.squares += sums[2];
    if (slope_x_.empty()) continue;
    const auto row = [&](const float* from) { return Eigen::Map<const Eigen::ArrayXf>(from, run.count); };
    const Eigen::ArrayXf pull = row(plateau_weight_.row(run.y).data() + first) *
                                (row(picture.row(py).data() + px) - row(shown_.row(run.y).data() + first));
    out.pull += Eigen::Vector2f((pull * row(slope_x_.row(run.y).data() + first)).sum(),
                                (pull * row(slope_y_.row(run.y).data() + first)).sum())
                    .cast<double>();
  }
  return out;
}

/// The same pixel by pixel: without what is not seen and what is `trim` sd off.
LayeredRegistration::Plateau LayeredRegistration::trimmed_plateau(const Picture& picture, int x, int y,
                                                                  const LayerLight& light,
                                                                  const Eigen::Vector2d& shift,
                                                                  double trim) const {
  Plateau out;
  const int left = x0_ - disc_.half() - x, top = y0_ - disc_.half() - y;
  for (const Run& run : runs_)
    for (int i = run.first; i < run.first + run.count; ++i) {
      const int px = left + i, py = top + run.y;
      const double weight = plateau_weight_.at(i, run.y);
      if (weight == 0 || px < 0 || py < 0 || px >= picture.width() || py >= picture.height()) continue;
      if (StaticIllumination::unseen(picture.at(px, py))) continue;
      const double u = i - disc_.half(), v = run.y - disc_.half();
      const double level = shown_.at(i, run.y);
      const Eigen::Vector2d gradient = shown_slope(i, run.y);
      const double off = picture.at(px, py) -
                         (light.gain + light.slope_x * u + light.slope_y * v) * (level - gradient.dot(shift));
      if (weight * off * off > trim * trim) continue;
      const double r = picture.at(px, py) - level;
      const Eigen::Vector3d column = level * Eigen::Vector3d(1, u, v);
      out.add(weight, column, gradient);
      out.force += weight * r * column;
      out.pull += weight * r * gradient;
      out.squares += weight * r * r;
    }
  return out;
}

}  // namespace tribotrack::vision
