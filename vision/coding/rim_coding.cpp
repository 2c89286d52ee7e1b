#include "vision/coding/rim_coding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

namespace tribotrack::vision {
namespace {

/// A place every two pixels: each cell that the rim crosses is met.
int places_on(const Circle& rim) {
  return std::max(16, static_cast<int>(std::numbers::pi * rim.radius));
}

}  // namespace

RimCoding rim_coding(const CodedFrame& frame, const Circle& rim) {
  RimCoding out;
  out.type = frame.type;
  if (frame.cells.empty()) return out;
  const int places = places_on(rim);
  double seen = 0;
  Point all;
  for (int k = 0; k < places; ++k) {
    const double phi = 2 * std::numbers::pi * k / places, x = std::cos(phi), y = std::sin(phi);
    const int column = static_cast<int>(std::floor((rim.x + rim.radius * x) / CodedFrame::kCell));
    const int row = static_cast<int>(std::floor((rim.y + rim.radius * y) / CodedFrame::kCell));
    if (column < 0 || row < 0 || column >= frame.columns || row >= frame.rows) continue;
    const CodedCell& cell = frame.cells[static_cast<std::size_t>(row * frame.columns + column)];
    ++seen;
    out.step += static_cast<double>(cell.step);
    all.x += x * x;
    all.y += y * y;
    if (cell.kind == CodedCell::Kind::intra) continue;
    Point& share = cell.kind == CodedCell::Kind::still ? out.still : out.moving;
    share.x += x * x;
    share.y += y * y;
  }
  if (seen == 0) return out;
  out.step /= seen;
  for (Point* share : {&out.still, &out.moving}) {
    share->x /= std::max(all.x, 1e-9);
    share->y /= std::max(all.y, 1e-9);
  }
  return out;
}

namespace {

/// Of all cells alike.
RimCoding picture_coding(const CodedFrame& frame) {
  RimCoding out;
  out.type = frame.type;
  out.step = frame.mean_step();
  if (frame.cells.empty()) return out;
  const double still = frame.still_share();
  const auto moving = std::ranges::count(frame.cells, CodedCell::Kind::moving, &CodedCell::kind);
  const double moves = static_cast<double>(moving) / static_cast<double>(frame.cells.size());
  out.still = {still, still};
  out.moving = {moves, moves};
  return out;
}

}  // namespace

void CodingWatch::see(std::int64_t index, const Point& centre, const std::optional<Circle>& mark) {
  if (!recording_.info().coder) return;
  WatchedFrame& frame = frames_.emplace_back();
  frame.index = index;
  const CodedFrame* coded = recording_.coded(index);
  if (!coded) return;
  frame.part = rim_coding(*coded, {centre.x, centre.y, radius_});
  frame.mark = mark ? rim_coding(*coded, *mark) : picture_coding(*coded);
}

namespace {

constexpr int kBlock = 8;
using Block = std::array<double, kBlock * kBlock>;
/// The largest coefficient of an orthonormal DCT.
double largest_coefficient(Block block) {
  cv::Mat levels(kBlock, kBlock, CV_64F, block.data());
  cv::dct(levels, levels);
  return cv::norm(levels, cv::NORM_INF);
}

struct Mean {
  double sum = 0, weight = 0;
  void add(const Block& slope) {
    double square = 0;
    for (const double s : slope) square += s * s;
    const double largest = largest_coefficient(slope);
    sum += square * largest;
    weight += square;
  }
  double unnoticed() const { return sum > 0 ? weight / sum : 0; }
};

bool counts(const Circle& rim, int left, int top, double margin) {
  const double middle = 0.5 * (kBlock - 1);
  const double off = std::hypot(left + middle - rim.x, top + middle - rim.y) - rim.radius;
  return margin < 0 ? off < middle : std::abs(off) < middle + margin;
}

}  // namespace

Point unnoticed_motion(const Picture& picture, const Circle& rim, double margin) {
  Mean along_x, along_y;
  for (int top = 0; top + kBlock <= picture.height(); top += kBlock)
    for (int left = 0; left + kBlock <= picture.width(); left += kBlock) {
      if (!counts(rim, left, top, margin)) continue;
      Block x{}, y{};
      for (int j = 0; j < kBlock; ++j)
        for (int i = 0; i < kBlock; ++i) {
          const auto level = [&](int dx, int dy) {
            return static_cast<double>(picture.at(std::clamp(left + i + dx, 0, picture.width() - 1),
                                                  std::clamp(top + j + dy, 0, picture.height() - 1)));
          };
          const auto at = static_cast<std::size_t>(j * kBlock + i);
          x[at] = 0.5 * (level(1, 0) - level(-1, 0));
          y[at] = 0.5 * (level(0, 1) - level(0, -1));
        }
      along_x.add(x);
      along_y.add(y);
    }
  return {along_x.unnoticed(), along_y.unnoticed()};
}

}  // namespace tribotrack::vision
