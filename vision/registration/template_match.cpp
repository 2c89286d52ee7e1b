#include "vision/registration/template_match.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace tribotrack::vision {
namespace {

cv::Mat as_mat(const Picture& picture) {
  return {picture.height(), picture.width(), CV_32F, const_cast<float*>(picture.levels().data())};
}

Picture averaged(const Picture& picture, int n) {
  Picture out(picture.width() / n, picture.height() / n);
  const float share = 1.0F / static_cast<float>(n * n);
  for (int y = 0; y < out.height() * n; ++y) {
    const auto from = picture.row(y);
    const auto to = out.row(y / n);
    for (int x = 0; x < out.width(); ++x) {
      float sum = 0;
      for (int i = 0; i < n; ++i) sum += from[static_cast<std::size_t>(x * n + i)];
      to[static_cast<std::size_t>(x)] += share * sum;
    }
  }
  return out;
}

/// Masked ZNCC at every position, as three plain correlations.
cv::Mat zncc_map(const Picture& picture, const MaskedTemplate& pattern) {
  double weight = 0;
  double mean = 0;
  for (std::size_t i = 0; i < pattern.levels.levels().size(); ++i) {
    weight += pattern.weights.levels()[i];
    mean += pattern.weights.levels()[i] * pattern.levels.levels()[i];
  }
  mean /= weight;
  const cv::Mat w = as_mat(pattern.weights);
  cv::Mat shape = (as_mat(pattern.levels) - mean).mul(w);
  const double norm = std::sqrt(std::max(1e-12, shape.dot(as_mat(pattern.levels) - mean)));
  cv::Mat levels = as_mat(picture) - cv::mean(as_mat(picture))[0];
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
  double mean = 0;
  for (std::size_t i = 0; i < shape_.levels().size(); ++i) {
    weight_ += weights_.levels()[i];
    mean += static_cast<double>(weights_.levels()[i]) * shape_.levels()[i];
  }
  mean /= weight_;
  pivot_ = static_cast<float>(mean);
  double squares = 0;
  for (std::size_t i = 0; i < shape_.levels().size(); ++i) {
    const double centred = shape_.levels()[i] - mean;
    squares += weights_.levels()[i] * centred * centred;
    shape_.levels()[i] = static_cast<float>(weights_.levels()[i] * centred);
  }
  const auto scale = static_cast<float>(squares > 0 ? 1 / std::sqrt(squares) : 0);
  for (float& level : shape_.levels()) level *= scale;
  for (int y = 0; y < height_; ++y) {
    const auto row = weights_.row(y);
    const auto has = [](float w) { return w > 0; };
    const auto first = std::find_if(row.begin(), row.end(), has);
    if (first == row.end()) continue;
    const auto last = std::find_if(row.rbegin(), row.rend(), has);
    spans_.push_back({y, static_cast<int>(first - row.begin()), static_cast<int>(row.rend() - last)});
  }
  reduction_ = std::clamp(std::min(width_, height_) / 14, 1, 16);
  if (reduction_ > 1) {
    const Picture weights = averaged(weights_, reduction_);
    reduced_ = {averaged(pattern.levels, reduction_), weights};
    for (float& w : reduced_.weights.levels()) w = w > 0.75F ? 1.0F : 0.0F;
  } else {
    reduced_ = pattern;
  }
}

double TemplateMatcher::score(const Picture& picture, int x, int y) const {
  double product = 0;
  double sum = 0;
  double squares = 0;
  for (const Span& span : spans_) {
    const float* level = picture.row(y + span.y).data() + x;
    const float* shape = shape_.row(span.y).data();
    const float* weight = weights_.row(span.y).data();
    // Four partial sums each: the compiler may not reorder a single one.
    float p[4] = {}, s[4] = {}, q[4] = {};
    int i = span.x0;
    for (; i + 4 <= span.x1; i += 4)
      for (int k = 0; k < 4; ++k) {
        const float centred = level[i + k] - pivot_;
        p[k] += shape[i + k] * centred;
        s[k] += weight[i + k] * centred;
        q[k] += weight[i + k] * centred * centred;
      }
    for (; i < span.x1; ++i) {
      const float centred = level[i] - pivot_;
      p[0] += shape[i] * centred;
      s[0] += weight[i] * centred;
      q[0] += weight[i] * centred * centred;
    }
    product += static_cast<double>(p[0] + p[1]) + (p[2] + p[3]);
    sum += static_cast<double>(s[0] + s[1]) + (s[2] + s[3]);
    squares += static_cast<double>(q[0] + q[1]) + (q[2] + q[3]);
  }
  const double spread = squares - sum * sum / weight_;
  return spread > 1e-6 * (weight_ + squares) ? product / std::sqrt(spread) : 0;
}

Match TemplateMatcher::best(const Picture& picture, int x0, int y0, int x1, int y1) const {
  x0 = std::max(x0, 0);
  y0 = std::max(y0, 0);
  x1 = std::min(x1, picture.width() - width_);
  y1 = std::min(y1, picture.height() - height_);
  Match best;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double ncc = score(picture, x, y);
      if (ncc > best.ncc) best = {x, y, ncc};
    }
  return best;
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
