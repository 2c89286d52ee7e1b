// Methods compared: error against run time, ours and others'. One kind of row for integrators, trackers and
// fits.
#pragma once

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
