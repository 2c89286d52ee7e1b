// A frame as a colour picture to draw on.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/io/levels.h"

namespace tribotrack::vision {

// BGR
inline const cv::Scalar kPath(0, 160, 255);
inline const cv::Scalar kOutline(80, 255, 80);
inline const cv::Scalar kMarker(255, 200, 0);
inline const cv::Scalar kBad(60, 60, 255);
inline const cv::Scalar kText(255, 255, 255);

/// Grey levels to 8 bits so that the darkest and brightest half per cent of the first frame just clip.
struct Stretch {
  float low = 0, high = 255;
  explicit Stretch(const Picture& picture) {
    std::vector<float> levels(picture.levels().begin(), picture.levels().end());
    low = level_of_share(levels, 0.005);
    high = std::max(level_of_share(levels, 0.995), low + 1);
  }
  cv::Mat operator()(const Picture& picture) const {
    const cv::Mat levels(picture.height(), picture.width(), CV_32F,
                         const_cast<float*>(picture.levels().data()));
    const double scale = 255.0 / (high - low);
    cv::Mat out;
    levels.convertTo(out, CV_8U, scale, -scale * low);
    return out;
  }
};

/// A colour canvas over a frame, enlarged, with drawing in the frame's pixel coordinates.
class Canvas {
 public:
  Canvas(const cv::Mat& grey, int enlargement) : scale_(enlargement) {
    cv::Mat large;
    cv::resize(grey, large, {}, scale_, scale_, scale_ > 1 ? cv::INTER_CUBIC : cv::INTER_NEAREST);
    cv::cvtColor(large, image_, cv::COLOR_GRAY2BGR);
    weight_ = std::max(1, image_.cols / 640);
  }
  cv::Mat& image() { return image_; }

  void line(const Point& a, const Point& b, const cv::Scalar& colour) {
    cv::line(image_, fixed(a), fixed(b), colour, weight_, cv::LINE_AA, kShift);
  }
  void circle(const Point& c, double radius, const cv::Scalar& colour) {
    const int r = static_cast<int>(std::lround(radius * scale_ * (1 << kShift)));
    cv::circle(image_, fixed(c), r, colour, weight_, cv::LINE_AA, kShift);
  }
  void dot(const Point& c, const cv::Scalar& colour) {
    const int r = static_cast<int>(std::lround(1.6 * weight_ * (1 << kShift)));
    cv::circle(image_, fixed(c), r, colour, cv::FILLED, cv::LINE_AA, kShift);
  }
  void cross(const Point& c, const cv::Scalar& colour) {
    const double arm = 5.0 * weight_ / scale_;
    line({c.x - arm, c.y}, {c.x + arm, c.y}, colour);
    line({c.x, c.y - arm}, {c.x, c.y + arm}, colour);
  }
  /// A name beside a circle, on the side where the picture has room.
  void label(const Circle& c, const std::string& words, const cv::Scalar& colour) {
    const double size = std::max(0.6, image_.cols / 1200.0);
    int base = 0;
    const cv::Size box = cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, size, 2, &base);
    const auto place = [&](double v) { return static_cast<int>((v + 0.5) * scale_); };
    int x = place(c.x + c.radius) + 3;
    if (x + box.width > image_.cols) x = place(c.x - c.radius) - 3 - box.width;
    const int y = std::clamp(place(c.y) + box.height / 2, box.height + 2, image_.rows - 3);
    cv::putText(image_, words, {x, y}, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 5, cv::LINE_AA);
    cv::putText(image_, words, {x, y}, cv::FONT_HERSHEY_SIMPLEX, size, colour, 2, cv::LINE_AA);
  }
  /// Lines every so many pixels that divides the picture into five to twelve, with their coordinates at the
  /// edges.
  void grid(const cv::Scalar& colour) {
    const double size = std::max(0.4, image_.cols / 2400.0);
    const int width = image_.cols / scale_, height = image_.rows / scale_;
    int step = 10;
    for (const int next : {20, 50, 100, 200, 500, 1000, 2000})
      if (std::max(width, height) / step > 12) step = next;
    const cv::Mat plain = image_.clone();
    for (int x = step; x < width; x += step) line({double(x), -0.5}, {double(x), height - 0.5}, colour);
    for (int y = step; y < height; y += step) line({-0.5, double(y)}, {width - 0.5, double(y)}, colour);
    cv::addWeighted(image_, 0.35, plain, 0.65, 0, image_);
    const auto write = [&](const std::string& words, cv::Point at) {
      cv::putText(image_, words, at, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 3, cv::LINE_AA);
      cv::putText(image_, words, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
    };
    for (int x = step; x < width; x += step) write(std::to_string(x), {x * scale_ + 3, image_.rows - 5});
    for (int y = step; y < height; y += step) write(std::to_string(y), {3, y * scale_ - 3});
  }
  /// One line of text in the top left corner, line 0, 1, ...; dark behind so that it reads on any ground.
  void text(int row, const std::string& words, const cv::Scalar& colour) {
    const double size = std::max(0.45, image_.cols / 1600.0);
    int base = 0;
    const cv::Size box = cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, size, 1, &base);
    const int step = box.height + base + 4;
    const cv::Point at(8, 8 + box.height + row * step);
    const cv::Rect back =
        cv::Rect(4, at.y - box.height - 3, box.width + 8, step) & cv::Rect(0, 0, image_.cols, image_.rows);
    image_(back) *= 0.4;
    cv::putText(image_, words, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
  }

 private:
  static constexpr int kShift = 5;  ///< binary places of the sub-pixel drawing coordinates
  cv::Point fixed(const Point& p) const {
    // Pixel centres at integers before and after enlargement.
    const auto to = [&](double v) {
      return static_cast<int>(std::lround(((v + 0.5) * scale_ - 0.5) * (1 << kShift)));
    };
    return {to(p.x), to(p.y)};
  }
  cv::Mat image_;
  int scale_;
  int weight_ = 1;
};

/// The whole factor by which small pictures are enlarged, so that they are legible.
inline int enlargement_for(const SourceInfo& info) {
  constexpr int kLegibleWidth = 960, kMost = 4;
  return std::clamp(kLegibleWidth / std::max(1, info.width), 1, kMost);
}

}  // namespace tribotrack::vision
