#include "vision/coding/coding_watch.h"

#include <algorithm>
#include <utility>

namespace tribotrack::vision {
namespace {

constexpr int kCell = CodedFrame::kCell;

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

bool equal(const Picture& a, const Picture& b, int left, int top) {
  const int right = std::min(left + kCell, a.width()), bottom = std::min(top + kCell, a.height());
  for (int y = top; y < bottom; ++y)
    if (!std::equal(a.row(y).begin() + left, a.row(y).begin() + right, b.row(y).begin() + left)) return false;
  return true;
}

}  // namespace

const CodedFrame& CodingWatch::by_pixels(std::int64_t index, char type) {
  std::swap(before_, now_);
  recording_.read(index, recording_.bounds(), now_);
  seen_.type = type;
  seen_.columns = (now_.width() + kCell - 1) / kCell;
  seen_.rows = (now_.height() + kCell - 1) / kCell;
  seen_.cells.assign(static_cast<std::size_t>(seen_.columns * seen_.rows), {});
  if (before_.empty()) return seen_;
  for (int row = 0; row < seen_.rows; ++row)
    for (int column = 0; column < seen_.columns; ++column)
      if (equal(before_, now_, kCell * column, kCell * row))
        seen_.cells[static_cast<std::size_t>(row * seen_.columns + column)].kind = CodedCell::Kind::still;
  return seen_;
}

void CodingWatch::see(std::int64_t index, const Point& centre, const std::optional<Circle>& mark) {
  if (!recording_.info().coder) return;
  WatchedFrame& frame = frames_.emplace_back();
  frame.index = index;
  const CodedFrame* told = recording_.coded(index);
  const bool tells = told && !told->cells.empty();
  const CodedFrame& coded = tells ? *told : by_pixels(index, told ? told->type : '?');
  frame.part = rim_coding(coded, {centre.x, centre.y, radius_});
  frame.mark = mark ? rim_coding(coded, *mark) : picture_coding(coded);
}

}  // namespace tribotrack::vision
