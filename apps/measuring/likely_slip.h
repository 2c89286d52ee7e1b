// A given value that is far from the one seen: by which slip?
#pragma once

#include <string>

namespace tribotrack::apps {

/// "9.995 is 62.8 rad/s in Hz", for a campaign key and its given and measured value in the unit of the key;
/// empty where none of the usual slips (another unit, peak to peak, radius for diameter, period for
/// frequency) comes within a tenth. The slips of one quantity differ by 40 % and more.
std::string likely_slip(const std::string& quantity, double given, double measured);

}  // namespace tribotrack::apps
