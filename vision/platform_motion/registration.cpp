#include "vision/platform_motion/motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "vision/kernels/dense.h"
#include "vision/kernels/parallel.h"
#include "vision/kernels/plane.h"
#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr int kBlock = 32;      ///< px: many widths of a texture, and light is even over it
constexpr double kOutlier = 4;  ///< sd
constexpr int kMostIterations = 20;
constexpr double kClose = 0.03;      ///< px: what is left of a step then makes no outliers of a ground
constexpr double kTolerance = 0.02;  ///< of the standard deviation: adds a thousandth to it
constexpr double kLeastSeen = 0.25;  ///< of the pixels

/// Of a block's sums over -slope_x, -slope_y, value, 1, level, the offset taken out of the rest.
struct WithoutOffset {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double squares = 0, weight = 0;

  explicit WithoutOffset(const NormalSums& sums) {
    const Eigen::Matrix<double, 5, 5> full = symmetric(sums, 5);
    weight = full(3, 3);
    if (!(weight > 0)) return;
    const Eigen::Matrix<double, 5, 5> centred = full - full.col(3) * full.row(3) / weight;
    normal = centred.topLeftCorner<3, 3>();
    force = centred.block<3, 1>(0, 4);
    squares = centred(4, 4);
  }
};

bool touches(const Rect& tile, const Circle& c) {
  return in_circle(c, std::clamp<double>(c.x, tile.x, tile.x + tile.width - 1),
                   std::clamp<double>(c.y, tile.y, tile.y + tile.height - 1));
}

double counted(const std::vector<float>& weights) {
  return static_cast<double>(std::ranges::count_if(weights, [](float w) { return w > 0; }));
}

}  // namespace

GroundRegistration::GroundRegistration(const Ground& ground, int threads)
    : ground_(ground), threads_(threads) {
  Picture weight = ground.variance;
  for (std::size_t i = 0; i < weight.levels().size(); ++i)
    weight.levels()[i] = ground.seen.levels()[i] > 0 ? 1 / weight.levels()[i] : 0;
  for (int top = 0; top < weight.height(); top += kBlock)
    for (int left = 0; left < weight.width(); left += kBlock) {
      Block& block = blocks_.emplace_back(Block{places_.size()});
      for (int y = top; y < std::min(top + kBlock, weight.height()); y += kTile)
        for (int x = left; x < std::min(left + kBlock, weight.width()); x += kTile) places_.push_back({x, y});
      block.end = places_.size();
    }
  known_ = under_tiles(weight, places_);
  pixels_ = counted(known_);
  arrays_.resize(places_.size());
  arrays_.slope_theta.resize(known_.size());
  arrays_.weight = known_;
  corners_.resize(places_.size());
  double squares = 0, sum = 0;
  for (Block& b : blocks_) {
    sample(b, {0, 0});
    const WithoutOffset sums(b.sums);
    squares += sums.normal(2, 2);
    sum += sums.weight;
  }
  texture_ = sum > 0 ? std::sqrt(std::max(0.0, squares / sum)) : 0;
}

/// Grey levels under the ground moved by whole pixels. False where too little of it is seen.
bool GroundRegistration::take(const GroundFrame& frame, int whole_x, int whole_y) {
  const int left = ground_.place.x + whole_x, top = ground_.place.y + whole_y;
  arrays_.weight = known_;
  take_levels(frame.picture, left - frame.window.x, top - frame.window.y, places_, ground_.level,
              arrays_.slope_theta, arrays_.weight);
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const Rect tile{left + places_[t].x, top + places_[t].y, kTile, kTile};
    for (const Circle& c : frame.hidden) {
      if (!touches(tile, c)) continue;
      for (std::size_t k = 0; k < kTilePixels; ++k)
        if (in_circle(c, tile.x + static_cast<int>(k % kTile), tile.y + static_cast<int>(k / kTile)))
          arrays_.weight[t * kTilePixels + k] = 0;
    }
  }
  return counted(arrays_.weight) > kLeastSeen * pixels_;
}

/// The ground under a block, moved by a fraction of a pixel, and the block's sums.
void GroundRegistration::sample(Block& block, const Point& fraction) {
  ground_.less.sample_tiles(-fraction.x, -fraction.y, places_, corners_, 0, true, arrays_, block.first,
                            block.end);
  block.sums = normal_sums(arrays_, block.first, block.end);
}

std::optional<GroundRegistration::Fit> GroundRegistration::solve(const Point& fraction) {
  parallel_for(blocks_.size(), threads_, [&](std::size_t k, std::size_t) { sample(blocks_[k], fraction); });
  Fit fit;
  fit.normal.setZero();
  fit.force.setZero();
  for (const Block& b : blocks_) {
    const WithoutOffset sums(b.sums);
    fit.normal += sums.normal;
    fit.force += sums.force;
    fit.of_levels += sums.squares;
  }
  fit.pixels = counted(arrays_.weight);
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(fit.normal);
  if (!lu.isInvertible()) return std::nullopt;
  fit.solution = lu.solve(fit.force);
  fit.squares = std::max(0.0, fit.of_levels - fit.solution.dot(fit.force));
  if (!fit.solution.allFinite() || !(fit.pixels > 0)) return std::nullopt;
  return fit;
}

/// Leaves out what cannot be noise. Returns how many pixels.
std::size_t GroundRegistration::trim(const Fit& fit) {
  parallel_for(blocks_.size(), threads_,
               [&](std::size_t k, std::size_t) { blocks_[k].trimmed = trim_block(blocks_[k], fit); });
  std::size_t count = 0;
  for (const Block& b : blocks_) count += b.trimmed;
  return count;
}

std::size_t GroundRegistration::trim_block(const Block& block, const Fit& fit) {
  // Sums of w value, w and w level.
  if (!(block.sums[12] > 0)) return 0;
  const auto gain = static_cast<float>(fit.solution(2));
  const auto limit = static_cast<float>(kOutlier * kOutlier * std::max(1.0, fit.squares / fit.pixels));
  const auto offset =
      static_cast<float>((block.sums[13] - fit.solution(2) * block.sums[10]) / block.sums[12]);
  const std::size_t first = block.first * kTilePixels, end = block.end * kTilePixels;
  std::vector<unsigned char> outliers(end - first);
  for (std::size_t i = first; i < end; ++i) {
    const float r = arrays_.slope_theta[i] - gain * arrays_.value[i] - offset;
    outliers[i - first] = arrays_.weight[i] * r * r > limit;
  }
  return leave_out(std::span(places_).subspan(block.first, block.end - block.first), std::move(outliers),
                   true, std::span(arrays_.weight).subspan(first, end - first));
}

void GroundRegistration::note_scatter(const Fit& fit) {
  const Eigen::Matrix3d inverse = fit.normal.inverse();
  Eigen::Matrix3d meat = Eigen::Matrix3d::Zero();
  double blocks = 0;
  for (const Block& b : blocks_) {
    const WithoutOffset sums(b.sums);
    if (!(sums.weight > 0)) continue;
    const Eigen::Vector3d force = sums.force - sums.normal * fit.solution;
    meat += force * force.transpose();
    ++blocks;
  }
  const double gain = fit.solution(2);
  normal_ = (inverse.topLeftCorner<2, 2>() / (gain * gain)).inverse();
  const Eigen::Matrix2d spread = (inverse * meat * inverse).topLeftCorner<2, 2>() / (gain * gain);
  scatter_ = normal_ * spread * normal_ * (blocks > 3 ? blocks / (blocks - 3) : 1);
}

std::optional<GroundFix> GroundRegistration::refine(const GroundFrame& frame, const Point& start) {
  int whole_x = static_cast<int>(std::lround(start.x)), whole_y = static_cast<int>(std::lround(start.y));
  Point fraction{start.x - whole_x, start.y - whole_y};
  if (!take(frame, whole_x, whole_y)) return std::nullopt;
  bool trimmed = false, converged = false;
  std::optional<Fit> fit;
  for (int k = 0; k < kMostIterations && !converged; ++k) {
    fit = solve(fraction);
    if (!fit) return std::nullopt;
    const Eigen::Vector2d step = fit->solution.head<2>() / std::max(std::abs(fit->solution(2)), 1e-3);
    const double length = step.norm();
    const double brake = length > 1 ? 1 / length : 1;  // the linearisation is good for a pixel at most
    fraction.x += brake * step.x();
    fraction.y += brake * step.y();
    if (std::hypot(whole_x + fraction.x - start.x, whole_y + fraction.y - start.y) > kFarthest)
      return std::nullopt;
    if (std::abs(fraction.x) > 0.75 || std::abs(fraction.y) > 0.75) {
      const int dx = static_cast<int>(std::lround(fraction.x)),
                dy = static_cast<int>(std::lround(fraction.y));
      whole_x += dx;
      whole_y += dy;
      fraction.x -= dx;
      fraction.y -= dy;
      if (!take(frame, whole_x, whole_y)) return std::nullopt;
      trimmed = false;
      continue;
    }
    if (!trimmed && length < kClose) {
      trimmed = true;
      if (trim(*fit) > 0) continue;
    }
    // In units of what is known: along a brush that is less.
    converged = trimmed && step.dot(fit->normal.topLeftCorner<2, 2>() * step) < kTolerance * kTolerance;
  }
  if (!converged || !(fit->solution(2) > 0)) return std::nullopt;
  note_scatter(*fit);
  GroundFix fix;
  fix.displacement = {whole_x + fraction.x, whole_y + fraction.y};
  fix.gain = fit->solution(2);
  double offset = 0, weight = 0;
  for (const Block& b : blocks_) {
    offset += b.sums[13] - fix.gain * b.sums[10];
    weight += b.sums[12];
  }
  fix.offset = offset / weight + ground_.level * (1 - fix.gain);
  fix.score = fit->force(2) / std::sqrt(fit->normal(2, 2) * fit->of_levels);
  // (N^-1/2) K (N^-1/2)
  const Eigen::Matrix2d root = inverse_root(normal_);
  fix.covariance = root * excess_ * root * std::max(1.0, fit->squares / fit->pixels);
  return fix;
}

}  // namespace tribotrack::vision
