// Figures in the terms of plotly.js: its traces, axes and shapes as JSON. Each figure is a function that
// returns one; the page (page/assets/figures.js) adds what depends on the screen: where the panels lie, and
// the colours of a dark one.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "apps/text/json.h"

namespace tribotrack::apps {

/// A number that is not there: a gap in a line, an end of an axis that the data decide.
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Panel {
  Json x, y;                      ///< axes: axis() and those after it
  std::vector<Json> traces = {};  ///< points(), line(), ...; none: an empty place
  std::vector<Json> shapes = {};  ///< stripe(), span()
  std::string title = {};
  double height = 1;         ///< of its row, relative to the others
  bool equal_scale = false;  ///< a millimetre is as long along y as along x
};

struct Figure {
  std::string id = {};       ///< letters, digits and '-': names files and places on the page
  std::string title = {};    ///< plain text, one line
  std::string caption = {};  ///< HTML; the title is not repeated in it
  /// What a reader who cannot see it should know, plain text.
  std::string alternative = {};
  int columns = 1;  ///< of panels, row by row
  std::vector<Panel> panels = {};
  Json colour_bar = {};   ///< colour_bar(); null: none
  bool shared_x = false;  ///< panels of a column share their x axis
  double height = 0.62;   ///< over width
  double width = 1;       ///< of the text's, on a wide screen
};

/// The most entries of a legend; more groups are told apart by a colour scale.
inline constexpr std::size_t kMostInLegend = 8;

using Values = std::vector<double>;
using Notes = std::vector<std::string>;

namespace plot {

// Traces. Those of one name share their entry in the legend, and are hidden together.

inline constexpr int kInk = -1;   ///< the colour of the text
inline constexpr int kGrey = -2;  ///< in the background

struct Look {
  int colour = 0;          ///< of the palette, or kInk, kGrey
  double on_ramp = kNone;  ///< 0 to 1: on the colour scale instead
  bool legend = false;     ///< one of those that share the name
  bool dashed = false;
  bool small = false;  ///< dots for many points, a thin line
  bool large = false;  ///< dots that stand out among others
};

/// `notes`: what each point is; `sd`: of y. Empty: none.
Json points(const std::string& name, const Values& x, const Values& y, const Look& look = {},
            const Notes& notes = {}, const Values& sd = {});
/// From point to point; kNone breaks it.
Json line(const std::string& name, const Values& x, const Values& y, const Look& look = {});
/// From `low` to `high` over x.
Json band(const std::string& name, const Values& x, const Values& low, const Values& high, const Look& look);
/// Notes in ink, written at the points.
Json labels(const Values& x, const Values& y, const Notes& notes);
/// Labels a little beyond the ends of paths; those that end at the same place share one.
Json end_numbers(const std::vector<Json>& paths, const Notes& numbers);

/// x or y of a trace.
Values values_of(const Json& trace, const char* key);

// Axes.

/// `title`: quantity and unit, plain text: "phase shift φ, rad". An end that is kNone: see settle_axes().
Json axis(const std::string& title, double low = kNone, double high = kNone);
/// Of a logarithm; ends as its exponents.
Json log_axis(const std::string& title, double low = kNone, double high = kNone);
/// An axis of angles in rad with ticks at multiples of pi/n, n of 1, 2, 3, 4, 6, 8, 12: the finest that gives
/// no more than eight ticks, thirds where the `values` lie on sixths but not on quarters. A range that holds
/// fewer than three of them has plotly's ticks.
Json angle_axis(const std::string& title, double low, double high, const Values& values = {});
/// Ticks at these places instead of round numbers.
Json with_ticks(Json axis, const Values& places, const Notes& texts);
Json with_zero_line(Json axis);
/// Neither numbers nor title, as between panels that share an axis.
Json hidden(Json axis);

// Behind the traces: "19 of 20 lie within", from `low` to `high` of y; times without a measurement, of x.

Json stripe(double low, double high);
Json span(double low, double high);

/// What Look::on_ramp means: 0 is `low`. `ticks`: an axis with such ends, and perhaps ticks.
Json colour_bar(const std::string& title, const Json& ticks);

}  // namespace plot

/// "5π/6" for k pi / n, reduced; "−π", "0".
std::string multiple_of_pi(long k, long n);

/// Ends that the data decide: those of all traces of a panel, of its column where the x axis is shared, with
/// a twentieth to spare, or whole decades. Equal scales take what room plotly has.
void settle_axes(Figure& figure);

// Ranges, and fewer points of long recordings: as many as an eye tells apart.

/// The finite values' least and greatest; {0, 1} where there is none, and never of length 0.
struct Range {
  double low = 0, high = 1;
  double size() const { return high - low; }
};
Range range_of(const Values& values);
/// With a share of its length added on both sides.
Range padded(const Range& range, double share);
/// The range that holds both.
Range hull(const Range& a, const Range& b);

struct DrawnPath {
  Values x, y;  ///< NaN where the pen is lifted
};

/// A curve of angles in [0, 2 pi), broken where it starts again at the other end. `half`: of a band about it.
struct AngleCurve {
  Values x, y, half;
};
AngleCurve broken_at_turns(const Values& x, const Values& y, const Values& half);

/// At most `most` points and the breaks between them: every n-th point, and a break wherever the path is
/// interrupted in between, so that no line crosses a gap. NaN: not measured.
DrawnPath thinned(const Values& x, const Values& y, std::size_t most);

/// Which points of a series in time are drawn: of each of most/2 equal stretches the lowest and the highest,
/// so that no outlier is lost; all where there are no more than `most`. A stretch without a finite value
/// gives its first point.
std::vector<std::size_t> envelope(const Values& y, std::size_t most);

/// The values at these places.
Values picked(const Values& values, const std::vector<std::size_t>& places);

// A figure as the page and other programs take it.

/// For plotly.js: "data" and "layout", panels numbered row by row, and "panels" with title and height of
/// each. Numbers are good to a tenth of a pixel. Axes must be settled.
Json plotly_json(const Figure& figure);

}  // namespace tribotrack::apps
