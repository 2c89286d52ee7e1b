#include "apps/bench/vision/matching.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace tribotrack::bench {

using namespace vision;

int template_reach(const Circle& disc) {
  return static_cast<int>(std::ceil(disc.radius)) + 3;
}

namespace {

cv::Mat matrix_of(const Picture& picture, int type) {
  const cv::Mat view(picture.height(), picture.width(), CV_32F, const_cast<float*>(picture.levels().data()));
  cv::Mat out;
  view.convertTo(out, type);
  return out;
}

/// The highest point of the correlation, between pixels by three points along each axis.
class MatchTemplate : public PositionMethod {
 public:
  enum class Peak { kParabola, kGaussian };

  MatchTemplate(const Picture& first, const Circle& disc, Peak peak) : peak_(peak) {
    const int reach = template_reach(disc);
    const int x = static_cast<int>(std::lround(disc.x)) - reach,
              y = static_cast<int>(std::lround(disc.y)) - reach;
    template_ = matrix_of(first, CV_8U)(cv::Rect(x, y, 2 * reach + 1, 2 * reach + 1)).clone();
    offset_ = {disc.x - x, disc.y - y};
  }
  std::string name() const override {
    return peak_ == Peak::kParabola ? "cv::matchTemplate + parabola" : "cv::matchTemplate + Gaussian";
  }
  void take(const Picture& picture) override { picture_ = matrix_of(picture, CV_8U); }
  Point locate() override {
    cv::matchTemplate(picture_, template_, scores_, cv::TM_CCOEFF_NORMED);
    cv::Point best;
    cv::minMaxLoc(scores_, nullptr, nullptr, nullptr, &best);
    return {best.x + offset_.x + between(best, 1, 0), best.y + offset_.y + between(best, 0, 1)};
  }

 private:
  double between(const cv::Point& best, int dx, int dy) const {
    if (best.x < dx || best.y < dy || best.x + dx >= scores_.cols || best.y + dy >= scores_.rows) return 0;
    double before = scores_.at<float>(best.y - dy, best.x - dx), middle = scores_.at<float>(best.y, best.x),
           after = scores_.at<float>(best.y + dy, best.x + dx);
    if (peak_ == Peak::kGaussian && before > 0 && after > 0) {
      before = std::log(before);
      middle = std::log(middle);
      after = std::log(after);
    }
    const double curvature = before - 2 * middle + after;
    return curvature < 0 ? 0.5 * (before - after) / curvature : 0;
  }

  Peak peak_;
  cv::Mat template_, picture_, scores_;
  Point offset_;
};

class PhaseCorrelate : public PositionMethod {
 public:
  PhaseCorrelate(const Picture& first, const Circle& disc)
      : first_(matrix_of(first, CV_32F)), start_{disc.x, disc.y} {
    cv::createHanningWindow(window_, first_.size(), CV_32F);
  }
  std::string name() const override { return "cv::phaseCorrelate"; }
  void take(const Picture& picture) override { picture_ = matrix_of(picture, CV_32F); }
  Point locate() override {
    const cv::Point2d shift = cv::phaseCorrelate(first_, picture_, window_);
    return {start_.x + shift.x, start_.y + shift.y};
  }

 private:
  cv::Mat first_, picture_, window_;
  Point start_;
};

/// Otsu's threshold finds the disc; its centre is that of the grey levels above the ground around it.
class GreyCentroid : public PositionMethod {
 public:
  explicit GreyCentroid(const Circle& disc) : radius_(disc.radius) {}
  std::string name() const override { return "grey centroid"; }
  void take(const Picture& picture) override { picture_ = matrix_of(picture, CV_8U); }
  Point locate() override {
    cv::threshold(picture_, mask_, 0, 1, cv::THRESH_BINARY | cv::THRESH_OTSU);
    const cv::Moments rough = cv::moments(mask_, true);
    if (!(rough.m00 > 0)) return {};
    const double x0 = rough.m10 / rough.m00, y0 = rough.m01 / rough.m00;
    const double inside = std::pow(radius_ + 4, 2), ground_from = std::pow(radius_ + 6, 2);
    double ground = 0, count = 0;
    for (int y = 0; y < picture_.rows; ++y)
      for (int x = 0; x < picture_.cols; ++x)
        if ((x - x0) * (x - x0) + (y - y0) * (y - y0) > ground_from) {
          ground += picture_.at<unsigned char>(y, x);
          count += 1;
        }
    if (count > 0) ground /= count;
    double weight = 0, mx = 0, my = 0;
    for (int y = 0; y < picture_.rows; ++y)
      for (int x = 0; x < picture_.cols; ++x)
        if ((x - x0) * (x - x0) + (y - y0) * (y - y0) <= inside) {
          const double w = picture_.at<unsigned char>(y, x) - ground;
          weight += w;
          mx += w * (x - x0);
          my += w * (y - y0);
        }
    return {x0 + mx / weight, y0 + my / weight};
  }

 private:
  double radius_;
  cv::Mat picture_, mask_;
};

}  // namespace

std::unique_ptr<PositionMethod> match_template(const Picture& first, const Circle& disc) {
  return std::make_unique<MatchTemplate>(first, disc, MatchTemplate::Peak::kParabola);
}

std::vector<std::unique_ptr<PositionMethod>> peer_position_methods(const Picture& first, const Circle& disc) {
  std::vector<std::unique_ptr<PositionMethod>> methods;
  methods.push_back(match_template(first, disc));
  methods.push_back(std::make_unique<MatchTemplate>(first, disc, MatchTemplate::Peak::kGaussian));
  methods.push_back(std::make_unique<PhaseCorrelate>(first, disc));
  methods.push_back(std::make_unique<GreyCentroid>(disc));
  return methods;
}

int set_opencv_threads(int count) {
  const int before = cv::getNumThreads();
  cv::setNumThreads(count);
  return before;
}

}  // namespace tribotrack::bench
