#include <algorithm>

#include "vision/frame_source.h"

namespace tribotrack::vision {

double CodedFrame::mean_step() const {
  double sum = 0;
  for (const CodedCell& cell : cells) sum += static_cast<double>(cell.step);
  return cells.empty() ? 0 : sum / static_cast<double>(cells.size());
}

double CodedFrame::still_share() const {
  const auto still = std::ranges::count(cells, CodedCell::Kind::still, &CodedCell::kind);
  return cells.empty() ? 0 : static_cast<double>(still) / static_cast<double>(cells.size());
}

}  // namespace tribotrack::vision
