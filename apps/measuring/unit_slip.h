// A given value that is far from the one seen: by which slip?
#pragma once

#include <string>

namespace tribotrack::apps {

/// Given and measured differ by more than this share: a slip, not an error of measuring. Of an angle it
/// counts in quarter turns.
inline constexpr double kSlipShare = 0.2;

/// "9.995 is 62.8 rad/s in Hz", for a campaign key and its given and measured value in the unit of the key;
/// empty where none of the usual slips (another unit, peak to peak, radius for diameter, period for
/// frequency) comes within a tenth. The slips of one quantity differ by 40 % and more.
std::string likely_slip(const std::string& quantity, double given, double measured);

}  // namespace tribotrack::apps
