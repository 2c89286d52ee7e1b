#include "vision/audit/halves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

/// Of the position's information: a half with less is no judge of the rest.
constexpr double kLeastShare = 0.01;
constexpr double kTileSide = 8;

}  // namespace

std::optional<HalvesError> halves_error(std::span<const TileSums> tiles, const TileSums::Matrix& normal,
                                        const Eigen::Matrix2d& covariance) {
  const FewFactor factor(normal);
  // One half against the other, in the units of the position's error.
  const auto disagreement = [&](auto in_half) -> std::optional<Eigen::Vector2d> {
    TileSums::Vector score = TileSums::Vector::Zero(normal.rows());
    TileSums::Matrix half = TileSums::Matrix::Zero(normal.rows(), normal.cols());
    for (const TileSums& tile : tiles) {
      if (!in_half(tile.place)) continue;
      score += tile.score;
      half += tile.normal;
    }
    const TileSums::Matrix spread = half - half * factor.solve(half);
    const Eigen::Matrix2d position = spread.topLeftCorner<2, 2>();
    for (Eigen::Index i = 0; i < 2; ++i)
      if (!(position(i, i) > kLeastShare * normal(i, i))) return std::nullopt;
    const Eigen::LLT<Eigen::Matrix2d> whitening(position), colouring(covariance);
    if (whitening.info() != Eigen::Success || colouring.info() != Eigen::Success) return std::nullopt;
    const Eigen::Vector2d white = whitening.matrixL().solve(score.head<2>());
    return colouring.matrixL() * white;
  };
  const auto left_right = disagreement([](const Point& place) { return place.x < 0; });
  const auto top_bottom = disagreement([](const Point& place) { return place.y < 0; });
  const auto checkerboard = disagreement([](const Point& place) {
    const double parity = std::floor(place.x / kTileSide) + std::floor(place.y / kTileSide);
    return std::fmod(std::abs(parity), 2) == 1;
  });
  if (!left_right || !top_bottom || !checkerboard) return std::nullopt;
  return HalvesError{*left_right, *top_bottom, *checkerboard};
}

namespace {

constexpr std::size_t kLeastFrames = 16;
constexpr double kCertain = 3;  ///< standard deviations: what is called slow is slow

/// Of one split in one frame, whitened, less what is constant over the recording.
struct Sample {
  std::int64_t index = 0;
  Eigen::Vector2d z;
};
using Split = std::vector<Sample>;  ///< in order, without outliers

Eigen::Vector2d middle_of(const std::vector<Eigen::Vector2d>& errors) {
  Eigen::Vector2d out;
  for (Eigen::Index i = 0; i < 2; ++i) {
    std::vector<double> values;
    for (const auto& e : errors) values.push_back(e(i));
    out(i) = median(values);
  }
  return out;
}

/// The constant is the mean weighted by the reported covariances, without single outliers.
Split split_of(const std::vector<AuditFrame>& frames, Eigen::Vector2d HalvesError::*of_split) {
  std::vector<Eigen::Vector2d> errors;
  for (const AuditFrame& frame : frames) errors.push_back(frame.error.*of_split);
  const Eigen::Vector2d middle = middle_of(errors);
  std::vector<Eigen::Matrix2d> whiten;
  std::vector<double> numbers;
  for (const AuditFrame& frame : frames) {
    whiten.emplace_back(frame.covariance.llt().matrixL().solve(Eigen::Matrix2d(Eigen::Matrix2d::Identity())));
    const Eigen::Vector2d z = whiten.back() * (frame.error.*of_split - middle);
    numbers.insert(numbers.end(), {z.x(), z.y()});
  }
  const double limit = outlier_size(numbers);
  const auto counts = [&](std::size_t k) {
    return std::max(std::abs(numbers[2 * k]), std::abs(numbers[2 * k + 1])) <= limit;
  };
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!counts(k)) continue;
    const Eigen::Matrix2d weight = whiten[k].transpose() * whiten[k];
    information += weight;
    sum += weight * errors[k];
  }
  const Eigen::Vector2d mean = information.llt().solve(sum);
  Split out;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (counts(k)) out.push_back({frames[k].index, whiten[k] * (errors[k] - mean)});
  return out;
}

/// Squares added up over consecutive frames: blocks show how far their sum is to be trusted even where errors
/// are alike from frame to frame.
struct Block {
  double square = 0, numbers = 0;
};
using Blocks = std::vector<Block>;

Block total(const Blocks& blocks) {
  Block all;
  for (const Block& b : blocks) all = {all.square + b.square, all.numbers + b.numbers};
  return all;
}

/// `lost` degrees of freedom; `efficiency`: numbers per independent one.
MeanSquare mean_of(const Blocks& blocks, double lost, double efficiency) {
  const Block all = total(blocks);
  MeanSquare out;
  out.value = all.square / std::max(1.0, all.numbers - lost);
  double spread = 0;
  for (const Block& b : blocks) spread += std::pow(b.square - out.value * b.numbers, 2);
  const auto count = static_cast<double>(blocks.size());
  const double clustered = count > 1 ? std::sqrt(spread * count / (count - 1)) / all.numbers : 0;
  out.scatter = std::max(clustered, out.value * std::sqrt(2 * efficiency / std::max(1.0, all.numbers)));
  return out;
}

/// Squares and successive differences of several splits.
struct Sums {
  Blocks squares, differences;
  void add(const Split& split) {
    std::int64_t begun = std::numeric_limits<std::int64_t>::min() / 2;
    for (std::size_t k = 0; k < split.size(); ++k) {
      const bool consecutive = k > 0 && split[k].index == split[k - 1].index + 1;
      if (!consecutive || split[k].index >= begun + kAuditRun) {
        squares.emplace_back();
        differences.emplace_back();
        begun = split[k].index;
      }
      squares.back().square += split[k].z.squaredNorm();
      squares.back().numbers += 2;
      if (!consecutive) continue;
      differences.back().square += (split[k].z - split[k - 1].z).squaredNorm() / 2;
      differences.back().numbers += 2;
    }
  }
};

/// Integral of the autocorrelation of the slow part, frames: pairs by their distance in octaves, up to where
/// it falls to nothing.
double slow_frames(const std::array<Split, 3>& splits, double slow) {
  struct Octave {
    double product = 0, lag = 0, numbers = 0;
  };
  std::vector<Octave> octaves;
  for (const Split& split : splits)
    for (std::size_t a = 0; a < split.size(); ++a)
      for (std::size_t b = a + 1; b < split.size(); ++b) {
        const auto lag = static_cast<double>(split[b].index - split[a].index);
        const auto octave = static_cast<std::size_t>(std::ilogb(lag));
        if (octave >= octaves.size()) octaves.resize(octave + 1);
        octaves[octave].product += split[a].z.dot(split[b].z);
        octaves[octave].lag += 2 * lag;
        octaves[octave].numbers += 2;
      }
  double integral = 0, last_lag = 0, last_share = 1;
  for (const Octave& o : octaves) {
    if (o.numbers == 0) continue;
    const double lag = o.lag / o.numbers, share = std::min(1.0, o.product / o.numbers / slow);
    if (share <= 0) return integral + 0.5 * last_share * (lag - last_lag) * last_share / (last_share - share);
    integral += 0.5 * (last_share + share) * (lag - last_lag);
    last_lag = lag;
    last_share = share;
  }
  return integral;
}

double ratio_of(const Split& split) {
  Sums sums;
  sums.add(split);
  return std::sqrt(mean_of(sums.squares, 2, 1).value);
}

}  // namespace

std::optional<HalvesFound> halves_found(const std::vector<AuditFrame>& frames) {
  if (frames.size() < kLeastFrames) return std::nullopt;
  const std::array<Split, 3> splits = {split_of(frames, &HalvesError::left_right),
                                       split_of(frames, &HalvesError::top_bottom),
                                       split_of(frames, &HalvesError::checkerboard)};
  Sums sums;
  for (const Split& split : splits) sums.add(split);
  HalvesFound out;
  out.left_right = ratio_of(splits[0]);
  out.top_bottom = ratio_of(splits[1]);
  out.total = mean_of(sums.squares, 6, 1);
  out.white = out.total;
  for (const AuditFrame& frame : frames)
    out.unit += 0.5 * frame.covariance.trace() / static_cast<double>(frames.size());
  const double numbers = total(sums.squares).numbers, pairs = total(sums.differences).numbers;
  if (pairs < 2 * kLeastFrames) return out;
  const MeanSquare successive = mean_of(sums.differences, 0, 1.5);
  const double slow = out.total.value - successive.value;
  if (slow <= kCertain * successive.value * std::sqrt(std::max(0.0, 3 / pairs - 2 / numbers))) return out;
  out.white = successive;
  out.slow_frames = slow_frames(splits, slow);
  return out;
}

bool in_audit(std::int64_t place, std::int64_t total) {
  if (total <= kAuditFrames) return true;
  constexpr std::int64_t kRuns = kAuditFrames / kAuditRun;
  for (std::int64_t k = 0; k < kRuns; ++k)
    if (const std::int64_t begin = k * (total - kAuditRun) / (kRuns - 1);
        place >= begin && place < begin + kAuditRun)
      return true;
  return false;
}

double outlier_size(const std::vector<double>& numbers) {
  constexpr double kFar = 5;
  constexpr double kMostOutliers = 0.25;
  std::vector<double> sizes;
  for (const double z : numbers) sizes.push_back(std::abs(z));
  const double limit = kFar * kNormalMad * median(sizes);
  double beyond = 0;
  for (const double size : sizes) beyond += size > limit;
  return beyond > kMostOutliers * static_cast<double>(sizes.size()) ? std::numeric_limits<double>::infinity()
                                                                    : limit;
}

double supported(const MeanSquare& found) {
  const double excess = found.value - 1;
  const double doubt = 2 * found.scatter;
  if (!(excess > doubt)) return 1;
  return 1 + excess - doubt * doubt / excess;
}

}  // namespace tribotrack::vision
