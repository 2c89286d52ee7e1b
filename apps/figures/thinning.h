// Fewer points of long recordings: as many as an eye tells apart.
#pragma once

#include <cstddef>
#include <vector>

namespace tribotrack::apps {

struct DrawnPath {
  std::vector<double> x, y;  ///< NaN where the pen is lifted
};

/// At most `most` points and the breaks between them: every n-th point, and a break wherever the path is
/// interrupted in between, so that no line crosses a gap. NaN: not measured.
DrawnPath thinned(const std::vector<double>& x, const std::vector<double>& y, std::size_t most);

/// Which points of a series in time are drawn: of each of most/2 equal stretches the lowest and the highest,
/// so that no outlier is lost; all where there are no more than `most`. A stretch without a finite value
/// gives its first point.
std::vector<std::size_t> envelope(const std::vector<double>& y, std::size_t most);

/// The values at these places.
std::vector<double> picked(const std::vector<double>& values, const std::vector<std::size_t>& places);

}  // namespace tribotrack::apps
