// Angles as users write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tribotrack::apps {

/// Radians from a number or an expression in pi: "0.5", "pi", "-pi/2", "11pi/9", "5*pi/6", "2.5 pi". nullopt
/// for anything else, "nan" and "inf" included.
std::optional<double> parse_angle(std::string_view text);

/// A plain finite number, the whole of the text. nullopt otherwise.
std::optional<double> parse_number(std::string_view text);

}  // namespace tribotrack::apps
