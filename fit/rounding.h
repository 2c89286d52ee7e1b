// Numbers rounded by their standard deviation: the one place where people's digits are chosen. Tables for
// programs keep all digits.
#pragma once

#include <string>

namespace tribotrack::fit {

/// A value rounded to the place of the second significant digit of its sd, trailing zeros kept: (0.100123,
/// 0.00031) gives "0.10012". rounded_to_sd(sd, sd) is the sd itself. Four significant digits without a usable
/// sd.
std::string rounded_to_sd(double value, double sd);

/// As papers write a value and its sd: "0.10012(31)" is 0.10012 +- 0.00031, "12.3(12)" 12.3 +- 1.2,
/// "1234(250)". "not determined" without a finite value and a finite sd; the value alone, in four digits, for
/// an sd of 0.
std::string quoted(double value, double sd);

/// The ends of an interval about a value with this sd, "0.09952 to 0.10073": rounded to the sd or finer, such
/// that half the interval's width keeps two digits; "open" for an end that is not finite.
std::string rounded_end(double end, double low, double high, double sd);

}  // namespace tribotrack::fit
