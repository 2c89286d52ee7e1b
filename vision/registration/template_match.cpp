#include "vision/registration/pattern.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

Picture averaged(const Picture& picture, int n) {
  Picture out(picture.width() / n, picture.height() / n);
  const cv::Mat whole_blocks = matrix_of(picture)({0, 0, out.width() * n, out.height() * n});
  cv::resize(whole_blocks, matrix_of(out), {out.width(), out.height()}, 0, 0, cv::INTER_AREA);
  return out;
}

/// Masked ZNCC at every position, as three plain correlations.
cv::Mat zncc_map(const Picture& picture, const MaskedTemplate& pattern) {
  const cv::Mat w = matrix_of(pattern.weights);
  const double weight = cv::sum(w)[0], mean = w.dot(matrix_of(pattern.levels)) / weight;
  cv::Mat shape = (matrix_of(pattern.levels) - mean).mul(w);
  const double norm = std::sqrt(std::max(1e-12, shape.dot(matrix_of(pattern.levels) - mean)));
  cv::Mat levels = matrix_of(picture) - cv::mean(matrix_of(picture))[0];
  cv::Mat product, sum, squares;
  cv::matchTemplate(levels, shape, product, cv::TM_CCORR);
  cv::matchTemplate(levels, w, sum, cv::TM_CCORR);
  cv::matchTemplate(levels.mul(levels), w, squares, cv::TM_CCORR);
  cv::Mat spread = squares - sum.mul(sum) / weight;
  // Flat ground has no correlation; the floor also covers the rounding of the transforms.
  const double floor = std::max(1e-3 * norm * norm * 1e-2, 0.02 * weight);
  cv::Mat map;
  cv::sqrt(cv::max(spread, floor), map);
  return product / (map * norm);
}

}  // namespace

TemplateMatcher::TemplateMatcher(const MaskedTemplate& pattern)
    : width_(pattern.levels.width()),
      height_(pattern.levels.height()),
      shape_(pattern.levels),
      weights_(pattern.weights) {
  const cv::Mat shape = matrix_of(shape_), weights = matrix_of(weights_);
  weight_ = cv::sum(weights)[0];
  pivot_ = shape.dot(weights) / weight_;
  cv::Mat centred = (shape - pivot_).mul(weights);
  const double squares = centred.dot(shape - pivot_);
  centred.convertTo(shape, CV_32F, squares > 0 ? 1 / std::sqrt(squares) : 0);
  reduction_ = std::clamp(std::min(width_, height_) / 14, 1, 16);
  if (reduction_ > 1) {
    reduced_ = {averaged(pattern.levels, reduction_), averaged(pattern.weights, reduction_)};
    for (float& w : reduced_.weights.levels()) w = w > 0.75F ? 1.0F : 0.0F;
  } else {
    reduced_ = pattern;
  }
}

double TemplateMatcher::score(const Picture& picture, int x, int y) const {
  const cv::Mat centred = matrix_of(picture)(cv::Rect(x, y, width_, height_)) - pivot_;
  const cv::Mat weighted = matrix_of(weights_).mul(centred);
  const double sum = cv::sum(weighted)[0], squares = weighted.dot(centred);
  const double spread = squares - sum * sum / weight_;
  return spread > 1e-6 * (weight_ + squares) ? matrix_of(shape_).dot(centred) / std::sqrt(spread) : 0;
}

Match TemplateMatcher::climb(const Picture& picture, Match from, int step) const {
  const int x_max = picture.width() - width_;
  const int y_max = picture.height() - height_;
  from.x = std::clamp(from.x, 0, x_max);
  from.y = std::clamp(from.y, 0, y_max);
  from.ncc = score(picture, from.x, from.y);
  while (step >= 1) {
    Match better = from;
    for (int dy = -step; dy <= step; dy += step)
      for (int dx = -step; dx <= step; dx += step) {
        const int x = from.x + dx;
        const int y = from.y + dy;
        if ((dx == 0 && dy == 0) || x < 0 || y < 0 || x > x_max || y > y_max) continue;
        const double ncc = score(picture, x, y);
        if (ncc > better.ncc) better = {x, y, ncc};
      }
    if (better.x == from.x && better.y == from.y)
      step /= 2;
    else
      from = better;
  }
  return from;
}

std::vector<Match> TemplateMatcher::search(const Picture& picture, double min_ncc, double separation,
                                           int max_count) const {
  if (picture.width() < width_ || picture.height() < height_) return {};
  const Picture small = reduction_ > 1 ? averaged(picture, reduction_) : picture;
  if (small.width() < reduced_.levels.width() || small.height() < reduced_.levels.height()) return {};
  cv::Mat map = zncc_map(small, reduced_);
  // The reduced grids of picture and template do not line up, which costs part of the score.
  const double coarse_min = reduction_ > 1 ? 0.6 * min_ncc : 0.9 * min_ncc;
  const int keep_out = std::max(1, static_cast<int>(separation / reduction_ / 2));
  std::vector<Match> found;
  for (int tries = 0; tries < 4 * max_count; ++tries) {
    double top = 0;
    cv::Point place;
    cv::minMaxLoc(map, nullptr, &top, nullptr, &place);
    if (!(top >= coarse_min)) break;
    cv::circle(map, place, keep_out, cv::Scalar(-1), cv::FILLED);
    const Match match =
        climb(picture, {place.x * reduction_, place.y * reduction_, top}, std::max(1, reduction_ / 2));
    if (match.ncc < min_ncc) continue;
    const bool known = std::any_of(found.begin(), found.end(), [&](const Match& other) {
      return std::hypot(other.x - match.x, other.y - match.y) < separation;
    });
    if (!known) found.push_back(match);
  }
  std::sort(found.begin(), found.end(), [](const Match& a, const Match& b) { return a.ncc > b.ncc; });
  if (found.size() > static_cast<std::size_t>(max_count)) found.resize(static_cast<std::size_t>(max_count));
  return found;
}

}  // namespace tribotrack::vision
