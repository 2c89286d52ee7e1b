// The heading of a table's column as people write it: "alpha_sd_deg", "v (mm/s)", "sigma x [px]".
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tribotrack::apps {

struct Heading {
  std::string quantity;  ///< its words in lower case, joined by `_`, without sd and unit: "alpha"
  std::string unit;      ///< "deg", "mm/s"; empty where there is none
  bool sd = false;       ///< the standard deviation of the quantity
};

/// Words are what stands between blanks, `_`, `/`, `.` and brackets. sd, std, stdev, sigma and uncertainty,
/// wherever they stand, mark the sd; the unit is a known one at the end and never the first word, so that `v`
/// is a quantity. Greek letters are read by their names.
Heading heading_of(std::string_view text);

enum class Dimension { angle, length, pixels, time, velocity, angular_frequency, frequency, voltage };

/// Factor to SI (angles: rad; pixels: 1) of a heading's unit; nullopt for one of another dimension.
std::optional<double> si_per(std::string_view unit, Dimension dimension);

}  // namespace tribotrack::apps
