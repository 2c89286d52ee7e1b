#include "vision/camera/pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr int kBlock = 16;     ///< of a single picture
constexpr int kPairBlock = 8;  ///< of a difference of two: small, so that few of them hold something moving
/// Of a picture, at least: a variance's estimate from so many blocks scatters by less than half a percent.
constexpr int kEnoughBlocks = 4000;
constexpr double kRounding = 1.0 / 12;

/// Mean over the blocks about the median that noise alone explains: what moves raises a block far beyond the
/// scatter of such an estimate, and the median of all with it.
double usual_of(std::vector<double>& blocks) {
  constexpr double kScatter = 0.178;  // sqrt(2 / (64 - 1))
  constexpr double kCut = 0.0177;     // phi(2.5) / Phi(2.5): the mean below 2.5 sd, in sd
  double estimate = median(blocks);
  for (int round = 0; round < 10; ++round) {
    double sum = 0, count = 0;
    for (const double b : blocks)
      if (b < (1 + 2.5 * kScatter) * estimate && b > (1 - 4 * kScatter) * estimate) {
        sum += b;
        ++count;
      }
    if (count == 0) break;
    estimate = sum / count / (1 - kCut * kScatter);
  }
  return estimate;
}

/// Means over blocks of so many px a side, next to each other in rows as high; exact for whole levels.
cv::Mat_<double> block_means(const cv::Mat& rows, int block) {
  cv::Mat_<double> means;
  if (rows.cols < block) return means;
  const cv::Rect whole(0, 0, rows.cols / block * block, block);
  cv::resize(rows(whole), means, {rows.cols / block, 1}, 0, 0, cv::INTER_AREA);
  return means;
}

/// Of so many rows of blocks one is looked at: a large picture holds more than are needed.
int row_stride(const Picture& picture, int block) {
  return std::max(1, picture.width() / block * (picture.height() / block) / kEnoughBlocks);
}

}  // namespace

void NoiseEstimate::add_pair(const Picture& a, const Picture& b) {
  std::vector<double> blocks;
  // Each pair looks at other rows.
  const int stride = row_stride(a, kPairBlock);
  for (int y = pairs_ % stride * kPairBlock; y + kPairBlock <= a.height(); y += stride * kPairBlock) {
    cv::Mat off;
    cv::subtract(matrix_of(a).rowRange(y, y + kPairBlock), matrix_of(b).rowRange(y, y + kPairBlock), off,
                 cv::noArray(), CV_64F);
    const cv::Mat_<double> mean = block_means(off, kPairBlock),
                           square = block_means(off.mul(off), kPairBlock);
    constexpr double n = kPairBlock * kPairBlock;
    for (int x = 0; x < mean.cols; ++x)
      if (const double variance = (square(x) - mean(x) * mean(x)) * n / (n - 1) / 2;
          variance > 0)  // 0: black, clipped, or a repeated frame
        blocks.push_back(variance);
  }
  if (blocks.empty()) return;
  sum_ += usual_of(blocks);
  ++pairs_;
}

double NoiseEstimate::variance(const Picture& first) const {
  // A texture that moves everywhere inflates the differences, a standing one the single picture.
  const double single = noise_variance(first);
  return std::max(pairs_ > 0 ? std::min(sum_ / pairs_, 1.1 * single) : single, kRounding);
}

double noise_variance(const Picture& picture) {
  if (picture.width() < kBlock + 2) return kRounding;
  std::vector<double> blocks;
  const cv::Mat_<float> bend = (cv::Mat_<float>(3, 1) << 1, -2, 1);
  const int stride = row_stride(picture, kBlock / 2);
  for (int y = 1; y + kBlock < picture.height(); y += stride * kBlock) {
    cv::Mat bends;
    cv::sepFilter2D(matrix_of(picture).rowRange(y - 1, y + kBlock + 1), bends, CV_64F, bend, bend);
    const cv::Mat inner = bends(cv::Rect(1, 1, picture.width() - 2, kBlock));
    const cv::Mat_<double> squares = block_means(inner.mul(inner), kBlock);
    for (const double square : squares)
      if (square > 0) blocks.push_back(square / 36);
  }
  return std::max(median(blocks), kRounding);
}

namespace {

constexpr double kNoises = 8;  ///< 1e6 pixels of Gaussian noise never stand out so far
constexpr float kSpreads = 2;

/// The eight neighbours, in order of their levels; fewer at the picture's edge.
struct Neighbours {
  std::array<float, 8> levels{};
  std::size_t count = 0;
  Neighbours(const Picture& picture, Pixel p) {
    for (int y = std::max(0, p.y - 1); y <= std::min(picture.height() - 1, p.y + 1); ++y)
      for (int x = std::max(0, p.x - 1); x <= std::min(picture.width() - 1, p.x + 1); ++x)
        if (x != p.x || y != p.y) levels[count++] = picture.at(x, y);
    std::sort(levels.begin(), levels.begin() + static_cast<std::ptrdiff_t>(count));
  }
  float low() const { return levels[1]; }
  float high() const { return levels[count - 2]; }
};

/// +1 bright, -1 dark, 0 as its neighbours.
int side_of(const Picture& picture, Pixel p, float least) {
  const Neighbours around(picture, p);
  const float here = picture.at(p.x, p.y);
  const float step = least + kSpreads * (around.high() - around.low());
  return here > around.high() + step ? 1 : here < around.low() - step ? -1 : 0;
}

/// A first look: what is that far from the median of the nine about it.
std::vector<Pixel> candidates(const Picture& picture, float least) {
  cv::Mat usual, off;
  cv::medianBlur(matrix_of(picture), usual, 3);
  cv::absdiff(matrix_of(picture), usual, off);
  std::vector<Pixel> found;
  for (int y = 1; y + 1 < picture.height(); ++y)
    for (int x = 1; x + 1 < picture.width(); ++x)
      if (off.at<float>(y, x) > least) found.push_back({x, y});
  return found;
}

bool is_before(const Pixel& a, const Pixel& b) {
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

}  // namespace

BadPixelSearch::BadPixelSearch(const Picture& picture, double noise_variance)
    : least_(static_cast<float>(kNoises * std::sqrt(noise_variance))) {
  if (picture.width() < 3 || picture.height() < 3) return;
  for (const Pixel& p : candidates(picture, least_))
    if (const int side = side_of(picture, p, least_); side != 0) {
      found_.push_back(p);
      sides_.push_back(side);
    }
}

void BadPixelSearch::look(const Picture& picture) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < found_.size(); ++k) {
    if (side_of(picture, found_[k], least_) != sides_[k]) continue;
    found_[kept] = found_[k];
    sides_[kept++] = sides_[k];
  }
  found_.resize(kept);
  sides_.resize(kept);
  ++others_;
}

MendedSource::MendedSource(FrameSource& source, std::vector<Pixel> bad)
    : source_(source), bad_(std::move(bad)) {
  info_ = source.info();
  std::sort(bad_.begin(), bad_.end(), is_before);
  for (const Pixel& p : bad_) {
    std::vector<Pixel>& around = healthy_.emplace_back();
    for (int reach = 1; around.empty() && reach <= 3; ++reach)
      for (int y = p.y - reach; y <= p.y + reach; ++y)
        for (int x = p.x - reach; x <= p.x + reach; ++x)
          if (bounds().contains({x, y, 1, 1}) &&
              !std::binary_search(bad_.begin(), bad_.end(), Pixel{x, y}, is_before))
            around.push_back({x, y});
  }
}

void MendedSource::fill(std::int64_t index, const Rect& window, Picture& picture) {
  source_.read(index, window, picture);
  const auto first = std::lower_bound(bad_.begin(), bad_.end(), Pixel{window.x, window.y}, is_before);
  for (auto p = first; p != bad_.end() && p->y < window.y + window.height; ++p) {
    if (p->x < window.x || p->x >= window.x + window.width) continue;
    std::vector<float> levels;
    for (const Pixel& q : healthy_[static_cast<std::size_t>(p - bad_.begin())])
      if (window.contains({q.x, q.y, 1, 1})) levels.push_back(picture.at(q.x - window.x, q.y - window.y));
    if (levels.empty()) continue;
    picture.at(p->x - window.x, p->y - window.y) = median(levels);
  }
}

}  // namespace tribotrack::vision
