#include "vision/coding/coding_watch.h"

#include <algorithm>

namespace tribotrack::vision {
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

}  // namespace tribotrack::vision
