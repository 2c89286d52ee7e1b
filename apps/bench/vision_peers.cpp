#include "apps/bench/vision_peers.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace tribotrack::bench {

using namespace vision;

namespace {

/// How far a search goes from the last position, px: several times what moves in these recordings.
constexpr int kSearch = 8;

/// A square about a target, as far as it lies in the frame.
Rect window_about(const Circle& target, int reach, const Rect& frame) {
  return common(frame, {static_cast<int>(std::lround(target.x)) - reach,
                        static_cast<int>(std::lround(target.y)) - reach, 2 * reach + 1, 2 * reach + 1});
}

/// The template's square reaches so far from the pixel nearest to the disc's centre, px.
int template_reach(const Circle& disc) {
  return static_cast<int>(std::ceil(disc.radius)) + 3;
}

cv::Mat matrix_of(const Picture& picture) {
  const cv::Mat view(picture.height(), picture.width(), CV_32F, const_cast<float*>(picture.levels().data()));
  cv::Mat out;
  view.convertTo(out, CV_8U);
  return out;
}

/// The highest point of the correlation, between pixels by three points along each axis.
class Matching {
 public:
  Matching(FrameSource& source, const Circle& target) : last_(target) {
    const Rect window = window_about(target, template_reach(target), source.bounds());
    source.read(0, window, picture_);
    template_ = matrix_of(picture_);
    offset_ = {target.x - window.x, target.y - window.y};
  }
  Point locate(FrameSource& source, std::int64_t index) {
    const Rect window = window_about(last_, template_reach(last_) + kSearch, source.bounds());
    source.read(index, window, picture_);
    cv::matchTemplate(matrix_of(picture_), template_, scores_, cv::TM_CCOEFF_NORMED);
    cv::Point best;
    cv::minMaxLoc(scores_, nullptr, nullptr, nullptr, &best);
    last_.x = window.x + best.x + offset_.x + between(best, 1, 0);
    last_.y = window.y + best.y + offset_.y + between(best, 0, 1);
    return {last_.x, last_.y};
  }

 private:
  double between(const cv::Point& best, int dx, int dy) const {
    if (best.x < dx || best.y < dy || best.x + dx >= scores_.cols || best.y + dy >= scores_.rows) return 0;
    const double before = scores_.at<float>(best.y - dy, best.x - dx),
                 middle = scores_.at<float>(best.y, best.x),
                 after = scores_.at<float>(best.y + dy, best.x + dx);
    const double curvature = before - 2 * middle + after;
    return curvature < 0 ? 0.5 * (before - after) / curvature : 0;
  }

  Circle last_;
  Picture picture_;
  cv::Mat template_, scores_;
  Point offset_;
};

/// Between pixel centres; the nearest pixel outside.
double level_at(const Picture& picture, double x, double y) {
  x = std::clamp(x, 0.0, picture.width() - 1.001);
  y = std::clamp(y, 0.0, picture.height() - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double u = x - i, v = y - j;
  return (1 - v) * ((1 - u) * picture.at(i, j) + u * picture.at(i + 1, j)) +
         v * ((1 - u) * picture.at(i, j + 1) + u * picture.at(i + 1, j + 1));
}

class CircleFit {
 public:
  CircleFit(FrameSource&, const Circle& target) : last_(target) {}
  Point locate(FrameSource& source, std::int64_t index) {
    const int reach = static_cast<int>(std::ceil(last_.radius)) + kSearch;
    const Rect window = window_about(last_, reach, source.bounds());
    source.read(index, window, picture_);
    const Circle before = last_;
    for (int round = 0; round < 3; ++round) fit(window, round == 0 ? HUGE_VAL : kOff);
    if (std::hypot(last_.x - before.x, last_.y - before.y) > kSearch) last_ = before;  // it ran away
    return {last_.x, last_.y};
  }

 private:
  static constexpr double kOff = 1.5;  ///< px from the circle found before: an edge of something else

  /// Through the edges that lie no farther than `off` from the circle of the round before.
  void fit(const Rect& window, double off) {
    const Point centre{last_.x - window.x, last_.y - window.y};
    const auto rays = std::clamp(std::lround(4 * last_.radius), 32L, 512L);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d side = Eigen::Vector3d::Zero();
    for (long k = 0; k < rays; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(rays);
      const double c = std::cos(angle), s = std::sin(angle), r = edge_along(centre, c, s);
      if (std::abs(r - last_.radius) > off) continue;
      const Eigen::Vector3d row(r * c, r * s, 1);
      normal += row * row.transpose();
      side += r * r * row;
    }
    if (normal(2, 2) < 8) return;  // points
    const Eigen::Vector3d found = normal.ldlt().solve(side);
    last_.x += found(0) / 2;
    last_.y += found(1) / 2;
  }
  /// Where the grey level is steepest, by a parabola through three differences.
  double edge_along(const Point& centre, double c, double s) const {
    constexpr double kStep = 0.5, kHalfWidth = 1, kFrom = 4;
    const auto steepness = [&](double r) {
      return std::abs(level_at(picture_, centre.x + (r + kHalfWidth) * c, centre.y + (r + kHalfWidth) * s) -
                      level_at(picture_, centre.x + (r - kHalfWidth) * c, centre.y + (r - kHalfWidth) * s));
    };
    double best = last_.radius, most = -1;
    for (double r = last_.radius - kFrom; r <= last_.radius + kFrom; r += kStep)
      if (const double here = steepness(r); here > most) {
        most = here;
        best = r;
      }
    const double before = steepness(best - kStep), after = steepness(best + kStep);
    const double curvature = before - 2 * most + after;
    return curvature < 0 ? best + 0.5 * kStep * (before - after) / curvature : best;
  }

  Circle last_;
  Picture picture_;
};

template <class Method>
std::vector<Point> follow(FrameSource& source, const std::vector<Circle>& targets) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  std::vector<Method> followed;
  for (const Circle& target : targets) followed.emplace_back(source, target);
  std::vector<Point> positions;
  for (std::int64_t k = 0; k < source.info().frame_count; ++k)
    for (std::size_t t = 0; t < followed.size(); ++t) {
      const Point found = followed[t].locate(source, k);
      if (t == 0) positions.push_back(found);
    }
  cv::setNumThreads(threads);
  return positions;
}

}  // namespace

std::vector<Point> follow_by_matching(FrameSource& source, const std::vector<Circle>& targets) {
  return follow<Matching>(source, targets);
}

std::vector<Point> follow_by_circle_fit(FrameSource& source, const std::vector<Circle>& targets) {
  return follow<CircleFit>(source, targets);
}

}  // namespace tribotrack::bench
