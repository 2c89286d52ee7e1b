#include "vision/coding/rim_coding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace tribotrack::vision
