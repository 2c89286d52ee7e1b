// Angles as users write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tribotrack::apps {

/// Radians from a number, an expression in pi or degrees: "0.5", "pi", "-pi/2", "11pi/9", "5*pi/6", "2.5 pi",
/// "90deg". nullopt for anything else, "nan" and "inf" included.
std::optional<double> parse_angle(std::string_view text);

/// What is wrong with an angle of more than two turns, which is no angle but one in degrees; else empty.
std::string angle_slip(double radians);

/// A plain finite number, the whole of the text. nullopt otherwise.
std::optional<double> parse_number(std::string_view text);

/// The parts of a text between the places of a character: one more than there are of these.
std::vector<std::string> parts_of(std::string_view text, char between);

/// In small letters, those of ASCII.
std::string lower(std::string_view text);

}  // namespace tribotrack::apps
