// Grey pictures and the places in them: the types that everything else in vision/ is written in.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

namespace tribotrack::vision {

/// A file that cannot be read, is not what it claims to be, or cannot be written. what() is one sentence for
/// the user naming file, place and remedy.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Pixel coordinates: pixel centres at integers, x right, y down, (0, 0) the first pixel.
struct Point {
  double x = 0;
  double y = 0;
};

struct Circle {
  double x = 0;
  double y = 0;
  double radius = 0;
};

/// Whole pixels x .. x + width - 1, y .. y + height - 1.
struct Rect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool contains(const Rect& other) const {
    return other.x >= x && other.y >= y && other.x + other.width <= x + width &&
           other.y + other.height <= y + height;
  }
};

/// What lies in both; width or height <= 0 where nothing does.
inline Rect common(const Rect& a, const Rect& b) {
  const int x0 = std::max(a.x, b.x), y0 = std::max(a.y, b.y);
  return {x0, y0, std::min(a.x + a.width, b.x + b.width) - x0, std::min(a.y + a.height, b.y + b.height) - y0};
}

/// A grey picture (or a window of one) in linear grey levels at the recording's own depth: 0 .. 2^bits - 1.
class Picture {
 public:
  Picture() = default;
  Picture(int width, int height, float value = 0)
      : width_(width), height_(height), levels_(static_cast<std::size_t>(width) * height, value) {}
  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return levels_.empty(); }
  float& at(int x, int y) { return levels_[static_cast<std::size_t>(y) * width_ + x]; }
  float at(int x, int y) const { return levels_[static_cast<std::size_t>(y) * width_ + x]; }
  std::span<float> row(int y) {
    return {levels_.data() + static_cast<std::size_t>(y) * width_, static_cast<std::size_t>(width_)};
  }
  std::span<const float> row(int y) const {
    return {levels_.data() + static_cast<std::size_t>(y) * width_, static_cast<std::size_t>(width_)};
  }
  std::span<float> levels() { return levels_; }
  std::span<const float> levels() const { return levels_; }

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<float> levels_;
};

}  // namespace tribotrack::vision
