// A figure as data: what it shows, whoever draws it. The page draws it with plotly.js
// (page/assets/figures.js), its numbers leave as CSV (figure_csv.h); both from this one
// description.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tribotrack::apps {

/// A number that is not there: a gap in a line, an end of an axis that the data decide.
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

enum class AxisScale { linear, logarithmic };

struct FigureAxis {
  std::string title = {};  ///< quantity and unit, plain text: "phase shift φ, rad"
  AxisScale scale = AxisScale::linear;
  double low = kNone, high = kNone;  ///< ends; kNone: see settle_axes() in axes.h
  std::vector<double> ticks = {};    ///< where, with `labels`; empty: round numbers, as the drawer finds them
  std::vector<std::string> labels = {};
  bool shown = true;  ///< false: neither numbers nor title, as between panels that share an axis
};

enum class Mark {
  points,
  line,  ///< from point to point; kNone breaks it
  band,  ///< from y to y_high over x
  bars,  ///< from 0 to x at height y, lying
  text,  ///< `notes` written at the points
};

/// Colours of series: an index into the palette of the drawers, or one of these.
inline constexpr int kInk = -1;   ///< as the text
inline constexpr int kGrey = -2;  ///< in the background

struct Series {
  Mark mark = Mark::points;
  std::string name = {};  ///< series of one name share their entry in the legend, and are hidden together
  std::vector<double> x = {}, y = {};
  std::vector<double> sd = {};          ///< of y; empty: no bars
  std::vector<double> y_high = {};      ///< of bands
  std::vector<std::string> notes = {};  ///< what each point is: the run's name
  int colour = 0;
  double value = kNone;    ///< with Figure::colours the place on its scale, instead of `colour`
  bool in_legend = false;  ///< one of those that share the name
  bool dashed = false;
  bool small = false;  ///< dots for many points, a thin line
  bool large = false;  ///< dots that stand out among others
};

/// A stripe in the background: "19 of 20 lie within".
struct Stripe {
  double low = 0, high = 0;
};

struct FigurePanel {
  FigureAxis x, y;
  std::vector<Series> series = {};
  std::vector<Stripe> stripes = {};  ///< of y
  std::vector<Stripe> spans = {};    ///< of x, standing: times without a measurement
  std::string title = {};
  double height = 1;         ///< of its row, relative to the others
  bool equal_scale = false;  ///< a millimetre is as long along y as along x
  bool zero_line = false;    ///< y = 0 is drawn
};

/// What Series::value means, where there are too many groups for a legend.
struct ColourScale {
  std::string title;
  double low = 0, high = 1;
  std::vector<double> ticks = {};
  std::vector<std::string> labels = {};
};

struct Figure {
  std::string id;       ///< letters, digits and '-': names files and places on the page
  std::string title;    ///< plain text, one line
  std::string caption;  ///< HTML; the title is not repeated in it
  /// What a reader who cannot see it should know, plain text.
  std::string alternative = {};
  int columns = 1;                       ///< of panels, row by row
  std::vector<FigurePanel> panels = {};  ///< without series: an empty place
  std::optional<ColourScale> colours = {};
  bool shared_x = false;  ///< panels of a column share their x axis
  double height = 0.62;   ///< over width
  double width = 1;       ///< of the text's, on a wide screen
};

/// The most entries of a legend; more groups are told apart by a colour scale.
inline constexpr std::size_t kMostInLegend = 8;

}  // namespace tribotrack::apps
