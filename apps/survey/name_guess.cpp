#include "apps/survey/name_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>

#include "apps/text/angle.h"

namespace tribotrack::apps {

namespace {

enum class Unit { unknown, degrees, radians };

/// A number of a name: "045", "0.79rad", "60p5deg".
struct Written {
  std::string digits;  ///< with a decimal point
  Unit unit = Unit::unknown;
  double value() const { return std::stod(digits); }
};

const std::string kNumber = R"(([+-]?[0-9]+(?:[.][0-9]+|p[0-9]+(?=[^0-9a-z]|$|deg|rad))?))";
const std::string kUnit = R"([ _]?(deg(?:rees)?|rad)?(?![a-z]))";

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

Written written(const std::string& number, const std::string& unit) {
  Written result{number, Unit::unknown};
  std::ranges::replace(result.digits, 'p', '.');
  if (unit.starts_with("rad"))
    result.unit = Unit::radians;
  else if (!unit.empty())
    result.unit = Unit::degrees;
  return result;
}

/// The number after one of some words, which stand at the beginning or after something that is no letter.
std::optional<Written> named(const std::string& name, const std::string& words) {
  const std::regex pattern("(?:^|[^a-z])(?:" + words + ")(?:[ _]?-?_?| ?= ?)" + kNumber + kUnit);
  std::smatch match;
  if (!std::regex_search(name, match, pattern)) return std::nullopt;
  return written(match[1], match[2]);
}

std::vector<Written> with_unit(const std::string& name) {
  const std::regex pattern("(?:^|[^0-9a-z.])" + kNumber + R"([ _]?(deg(?:rees)?|rad)(?![a-z]))");
  std::vector<Written> all;
  for (std::sregex_iterator at(name.begin(), name.end(), pattern), end; at != end; ++at)
    all.push_back(written((*at)[1], (*at)[2]));
  return all;
}

struct Angles {
  std::optional<Written> phi, dtau;
};

Angles angles_in(const std::string& name) {
  Angles angles{named(name, "phi|phase|ph|p"), named(name, "dtau|deltatau|delta_tau|tau|dt|width|d|w")};
  if (angles.phi || angles.dtau) return angles;
  const std::vector<Written> numbers = with_unit(name);
  if (!numbers.empty()) angles.phi = numbers[0];
  if (numbers.size() > 1) angles.dtau = numbers[1];
  return angles;
}

/// That of the numbers whose names state none.
Unit unit_of(const std::vector<Angles>& all) {
  bool fraction = false;
  for (const Angles& angles : all)
    for (const auto* number : {&angles.phi, &angles.dtau}) {
      if (!*number || (*number)->unit != Unit::unknown) continue;
      const std::string& digits = (*number)->digits;
      const bool leading_zero = digits.size() > 1 && digits[0] == '0' && digits[1] != '.';
      if (leading_zero || std::abs((*number)->value()) > 2 * std::numbers::pi + 0.01) return Unit::degrees;
      fraction = fraction || digits.find('.') != std::string::npos;
    }
  return fraction ? Unit::radians : Unit::unknown;
}

void settle(const std::optional<Written>& number, Unit common, std::optional<double>& radians,
            std::string& text) {
  if (!number) return;
  const Unit unit = number->unit == Unit::unknown ? common : number->unit;
  if (unit == Unit::unknown) return;
  const std::string plain = fmt::format("{}", number->value());
  text = unit == Unit::degrees ? plain + "deg" : plain;
  radians = parse_angle(text);
}

std::optional<double> frame_rate_in(const std::string& name) {
  static const std::regex pattern(R"((?:^|[^0-9.a-z])([0-9]+(?:\.[0-9]+)?)[ _]?(?:fps|hz)(?![a-z]))");
  std::smatch match;
  if (!std::regex_search(name, match, pattern)) return std::nullopt;
  const double rate = std::stod(match[1]);
  return rate > 0 ? std::optional(rate) : std::nullopt;
}

}  // namespace

std::vector<NameGuess> guesses_from(const std::vector<std::string>& names) {
  std::vector<Angles> angles;
  for (const std::string& name : names) angles.push_back(angles_in(lower(name)));
  const Unit common = unit_of(angles);
  std::vector<NameGuess> guesses;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::string name = lower(names[k]);
    NameGuess guess;
    settle(angles[k].phi, common, guess.phi_rad, guess.phi_text);
    settle(angles[k].dtau, common, guess.dtau_rad, guess.dtau_text);
    guess.frame_rate_hz = frame_rate_in(name);
    guess.free_slide = name.find("slide") != std::string::npos || name.find("incline") != std::string::npos;
    guesses.push_back(guess);
  }
  return guesses;
}

}  // namespace tribotrack::apps
