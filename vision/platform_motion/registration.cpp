#include "vision/platform_motion/registration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "vision/kernels/dense.h"
#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr int kBlock = 32;      ///< px: many widths of a texture, and light is even over it
constexpr double kOutlier = 4;  ///< sd
constexpr int kMostIterations = 20;
constexpr int kMostTrims = 4;
constexpr double kTolerance = 0.02;  ///< of the standard deviation: adds a thousandth to it
constexpr double kLeastSeen = 0.25;  ///< of the pixels

/// Of a block's sums over -slope_x, -slope_y, value, 1, level, the offset taken out of the rest.
struct WithoutOffset {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double squares = 0, weight = 0;

  explicit WithoutOffset(const NormalSums& s) {
    Eigen::Matrix<double, 5, 5> full;
    for (int i = 0, k = 0; i < 5; ++i)
      for (int j = i; j < 5; ++j, ++k) full(i, j) = full(j, i) = s[static_cast<std::size_t>(k)];
    weight = full(3, 3);
    if (!(weight > 0)) return;
    const Eigen::Matrix<double, 5, 5> centred = full - full.col(3) * full.row(3) / weight;
    normal = centred.topLeftCorner<3, 3>();
    force = centred.block<3, 1>(0, 4);
    squares = centred(4, 4);
  }
};

bool touches(const Rect& tile, const Circle& c) {
  const double dx = c.x - std::clamp<double>(c.x, tile.x, tile.x + tile.width - 1);
  const double dy = c.y - std::clamp<double>(c.y, tile.y, tile.y + tile.height - 1);
  return dx * dx + dy * dy <= c.radius * c.radius;
}

}  // namespace

GroundRegistration::GroundRegistration(const Ground& ground) : ground_(ground) {
  add_blocks();
  sample({0, 0});
  double squares = 0, weight = 0;
  for (Block& b : blocks_) {
    b.shown = b.arrays.weight = b.weight;
    pixels_ += static_cast<double>(std::ranges::count_if(b.weight, [](float w) { return w > 0; }));
    const WithoutOffset sums(normal_sums(b.arrays));
    squares += sums.normal(2, 2);
    weight += sums.weight;
  }
  texture_ = weight > 0 ? std::sqrt(std::max(0.0, squares / weight)) : 0;
}

void GroundRegistration::add_blocks() {
  for (int top = 0; top < ground_.place.height; top += kBlock)
    for (int left = 0; left < ground_.place.width; left += kBlock) {
      Block b;
      for (int y = top; y < std::min(top + kBlock, ground_.place.height); y += kTile)
        for (int x = left; x < std::min(left + kBlock, ground_.place.width); x += kTile)
          b.tiles.push_back({x, y});
      for (const TilePlace& t : b.tiles)
        for (int y = t.y; y < t.y + kTile; ++y)
          for (int x = t.x; x < t.x + kTile; ++x) {
            const bool known =
                x < ground_.place.width && y < ground_.place.height && ground_.seen.at(x, y) > 0;
            b.weight.push_back(known ? 1 / ground_.variance.at(x, y) : 0);
          }
      b.corners.resize(b.tiles.size());
      b.arrays.tiles = b.tiles.size();
      for (auto* v :
           {&b.arrays.value, &b.arrays.slope_x, &b.arrays.slope_y, &b.arrays.slope_theta, &b.arrays.level})
        v->resize(b.weight.size());
      blocks_.push_back(std::move(b));
    }
}

/// Grey levels under the ground moved by whole pixels. False where too little of it is seen.
bool GroundRegistration::take(const GroundFrame& frame, int whole_x, int whole_y) {
  double seen = 0;
  const int left = ground_.place.x + whole_x, top = ground_.place.y + whole_y;
  for (Block& b : blocks_) {
    b.shown = b.weight;
    take_levels(frame.picture, left - frame.window.x, top - frame.window.y, b.tiles, ground_.level,
                b.arrays.level, b.shown);
    for (std::size_t t = 0; t < b.tiles.size(); ++t) {
      const Rect tile{left + b.tiles[t].x, top + b.tiles[t].y, kTile, kTile};
      for (const Circle& c : frame.hidden) {
        if (!touches(tile, c)) continue;
        for (std::size_t k = 0; k < kTilePixels; ++k) {
          const double dx = tile.x + static_cast<int>(k % kTile) - c.x,
                       dy = tile.y + static_cast<int>(k / kTile) - c.y;
          if (dx * dx + dy * dy <= c.radius * c.radius) b.shown[t * kTilePixels + k] = 0;
        }
      }
    }
    b.arrays.slope_theta = b.arrays.level;
    b.arrays.weight = b.shown;
    seen += static_cast<double>(std::ranges::count_if(b.shown, [](float w) { return w > 0; }));
  }
  return seen > kLeastSeen * pixels_;
}

void GroundRegistration::sample(const Point& fraction) {
  for (Block& b : blocks_)
    ground_.less.sample_tiles(-fraction.x, -fraction.y, b.tiles, b.corners, 0, true, b.arrays);
}

std::optional<GroundRegistration::Fit> GroundRegistration::solve() {
  Fit fit;
  fit.normal.setZero();
  fit.force.setZero();
  for (Block& b : blocks_) {
    b.sums = normal_sums(b.arrays);
    const WithoutOffset sums(b.sums);
    fit.normal += sums.normal;
    fit.force += sums.force;
    fit.of_levels += sums.squares;
    fit.pixels += static_cast<double>(std::ranges::count_if(b.arrays.weight, [](float w) { return w > 0; }));
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(fit.normal);
  if (!lu.isInvertible()) return std::nullopt;
  fit.solution = lu.solve(fit.force);
  fit.squares = std::max(0.0, fit.of_levels - fit.solution.dot(fit.force));
  if (!fit.solution.allFinite() || !(fit.pixels > 0)) return std::nullopt;
  return fit;
}

/// Leaves out what cannot be noise. Returns how many pixels.
std::size_t GroundRegistration::trim(const Fit& fit) {
  const auto gain = static_cast<float>(fit.solution(2));
  const auto limit = static_cast<float>(kOutlier * kOutlier * std::max(1.0, fit.squares / fit.pixels));
  std::size_t count = 0;
  for (Block& b : blocks_) {
    // Sums of w value, w and w level.
    if (!(b.sums[12] > 0)) continue;
    const auto offset = static_cast<float>((b.sums[13] - fit.solution(2) * b.sums[10]) / b.sums[12]);
    std::vector<unsigned char> outliers(b.shown.size());
    for (std::size_t i = 0; i < b.shown.size(); ++i) {
      const float r = b.arrays.level[i] - gain * b.arrays.value[i] - offset;
      outliers[i] = b.shown[i] * r * r > limit;
    }
    b.arrays.weight = b.shown;
    if (spread_outliers(b.tiles, outliers) == 0) continue;
    for (std::size_t i = 0; i < b.shown.size(); ++i)
      if (outliers[i] != 0 && b.shown[i] > 0) {
        b.arrays.weight[i] = 0;
        ++count;
      }
  }
  return count;
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
  std::size_t trimmed = 0;
  int trims = 0;
  std::optional<Fit> fit;
  bool converged = false;
  for (int k = 0; k < kMostIterations && !converged; ++k) {
    sample(fraction);
    fit = solve();
    if (!fit) return std::nullopt;
    const Eigen::Vector2d step = fit->solution.head<2>() / std::max(std::abs(fit->solution(2)), 1e-3);
    const double length = step.norm();
    const double brake = length > 1 ? 1 / length : 1;  // the linearisation is good for a pixel at most
    fraction.x += brake * step.x();
    fraction.y += brake * step.y();
    if (std::hypot(whole_x + fraction.x - start.x, whole_y + fraction.y - start.y) > kFarthest)
      return std::nullopt;
    // In units of what is known: along a brush that is less.
    const bool settled =
        brake == 1 && step.dot(fit->normal.topLeftCorner<2, 2>() * step) < kTolerance * kTolerance;
    if (settled) {
      const std::size_t before = trimmed;
      trimmed = trims < kMostTrims ? trim(*fit) : trimmed;
      converged = trims++ >= kMostTrims || trimmed == before;
    }
    if (std::abs(fraction.x) > 0.75 || std::abs(fraction.y) > 0.75) {
      const int dx = static_cast<int>(std::lround(fraction.x)),
                dy = static_cast<int>(std::lround(fraction.y));
      whole_x += dx;
      whole_y += dy;
      fraction.x -= dx;
      fraction.y -= dy;
      if (!take(frame, whole_x, whole_y)) return std::nullopt;
      trimmed = 0;
      converged = false;
    }
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
