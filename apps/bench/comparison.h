// Methods compared: error against run time, ours and others'. One kind of row for integrators, trackers and
// fits.
#pragma once

#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace tribotrack::bench {

/// What one benchmark knows of its rows besides, named as in its CSV.
struct Detail {
  const char* name;
  double value;
};

/// One method at one setting on one scene.
struct ComparedRow {
  std::string group;  ///< of scenes: a line of the summary, a panel of the figure
  std::string scene;  ///< rows of one scene are set against each other
  std::string method, setting;
  bool ours = false;    ///< as users get it
  bool arrived = true;  ///< false: it gave up, or ended elsewhere
  double error = 0;     ///< in the comparison's unit
  double time = 0;      ///< s, CPU time
  std::vector<Detail> details = {};
  /// Of a peer that arrived: both against one and the same row of ours, the fastest with no larger error or,
  /// where none is as accurate, the most accurate. NaN for all others.
  double error_over_ours = std::numeric_limits<double>::quiet_NaN();
  double time_over_ours = error_over_ours;

  double at(std::string_view name) const {
    for (const Detail& detail : details)
      if (detail.name == name) return detail.value;
    throw std::out_of_range("no such detail of a benchmark's row");
  }
};

/// What one benchmark compares.
struct Comparison {
  std::string name;         ///< "model", "vision", "fit"
  std::string title;        ///< of the figure
  std::string error, unit;  ///< what the error is of, and its unit
  std::string time;         ///< what is timed
  std::string reference;    ///< where the truth comes from
  /// The summary names the fastest with no larger error (infinite: of all that arrive); 0: the most accurate.
  double target = 0;
  std::vector<ComparedRow> rows = {};
};

/// Errors this close count as equal.
inline constexpr double kSameError = 1e-3;

/// Sets the peers' ratios.
void set_against_ours(Comparison& comparison);

/// Less error or less time than the row of ours it is set against.
bool peer_wins(const ComparedRow& row);
/// "PEER WINS ..." where it does; empty for our own rows.
std::string verdict(const ComparedRow& row);

/// A group of scenes in one line, medians over its scenes. Plain text.
struct SummaryLine {
  std::string measured, ours;
  std::string peer;  ///< the best of the others
  std::string who;   ///< wins where
};
std::vector<SummaryLine> summary_of(const Comparison& comparison);

/// "3.2 us", "3.2 ms", "3.2 s".
std::string time_text(double seconds);

}  // namespace tribotrack::bench
