// Ranges and ticks of a figure's axes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/figures/figure.h"

namespace tribotrack::apps {

/// "5π/6" for k pi / n, reduced; "−π", "0".
std::string multiple_of_pi(long k, long n);

/// An axis of angles in rad from `low` to `high`, with ticks at multiples of pi/n, n of 1, 2, 3, 4, 6, 8, 12:
/// the finest that gives no more than eight ticks, thirds where the `values` lie on sixths but not on
/// quarters. A range that holds fewer than three of them has the drawer's ticks.
FigureAxis angle_axis(const std::string& title, double low, double high,
                      const std::vector<double>& values = {});

/// The finite values' least and greatest; {0, 1} where there is none, and never of length 0.
struct Range {
  double low = 0, high = 1;
  double size() const { return high - low; }
};
Range range_of(const std::vector<double>& values);
/// With a share of its length added on both sides.
Range padded(const Range& range, double share);
/// The range that holds both.
Range hull(const Range& a, const Range& b);

/// Ends that the data decide: those of all series of a panel, of its column where the x axis is shared, with
/// a twentieth to spare, or whole decades. Equal scales take what room the drawer has.
void settle_axes(Figure& figure);

// Fewer points of long recordings: as many as an eye tells apart.

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
