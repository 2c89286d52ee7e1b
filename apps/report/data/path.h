// Long tracks thinned for drawing.
#pragma once

#include <cstddef>
#include <vector>

namespace tribotrack::apps {

/// Points to be joined by a line; NaN lifts the pen.
struct DrawnPath {
  std::vector<double> x, y;
};

/// Every k-th point, k the smallest that leaves at most `most` of them. A gap (NaN in x or y), however short,
/// stays a gap: where one falls between two drawn points, a NaN is put in. With most >= 50 per cycle loops
/// keep their shape.
DrawnPath thinned(const std::vector<double>& x, const std::vector<double>& y, std::size_t most);

}  // namespace tribotrack::apps
