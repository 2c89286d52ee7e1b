#include "apps/text/heading.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

namespace tribotrack::apps {

namespace {

struct Unit {
  std::string_view name;
  Dimension dimension;
  double si;
};

constexpr double kDegree = std::numbers::pi / 180;

constexpr std::array kUnits = {
    Unit{"rad", Dimension::angle, 1},        Unit{"deg", Dimension::angle, kDegree},
    Unit{"m", Dimension::length, 1},         Unit{"cm", Dimension::length, 1e-2},
    Unit{"mm", Dimension::length, 1e-3},     Unit{"um", Dimension::length, 1e-6},
    Unit{"px", Dimension::pixels, 1},        Unit{"s", Dimension::time, 1},
    Unit{"ms", Dimension::time, 1e-3},       Unit{"us", Dimension::time, 1e-6},
    Unit{"ns", Dimension::time, 1e-9},       Unit{"m/s", Dimension::velocity, 1},
    Unit{"cm/s", Dimension::velocity, 1e-2}, Unit{"mm/s", Dimension::velocity, 1e-3},
    Unit{"um/s", Dimension::velocity, 1e-6}, Unit{"rad/s", Dimension::angular_frequency, 1},
    Unit{"hz", Dimension::frequency, 1},     Unit{"v", Dimension::voltage, 1},
    Unit{"mv", Dimension::voltage, 1e-3},    Unit{"uv", Dimension::voltage, 1e-6}};

/// Other spellings, of a word or of a part of one.
constexpr std::array<std::pair<std::string_view, std::string_view>, 26> kSpellings = {
    {{"\xcf\x86", "phi"}, {"\xcf\x95", "phi"},   {"\xce\xb1", "alpha"}, {"\xce\x94", "d"},
     {"\xce\xb4", "d"},   {"\xcf\x84", "tau"},   {"\xcf\x89", "w"},     {"\xcf\x83", "sigma"},
     {"\xc2\xb0", "deg"}, {"\xc2\xb5", "u"},     {"\xce\xbc", "u"},     {"\xe2\x81\xbb\xc2\xb9", "^-1"},
     {"\xc2\xb7", " "},   {"\xe2\x8b\x85", " "}, {"\xef\xbb\xbf", ""},  {"s^-1", "s"},
     {"s-1", "s"},        {"degrees", "deg"},    {"degree", "deg"},     {"radians", "rad"},
     {"pixels", "px"},    {"pixel", "px"},       {"seconds", "s"},      {"second", "s"},
     {"volts", "v"},      {"volt", "v"}}};

std::string plain(std::string_view text) {
  std::string kept(text);
  for (char& c : kept)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const auto& [from, to] : kSpellings)
    for (auto at = kept.find(from); at != std::string::npos; at = kept.find(from, at + to.size()))
      kept.replace(at, from.size(), to);
  return kept;
}

std::vector<std::string> words_of(const std::string& text) {
  constexpr std::string_view kBetween = " \t_/.()[]{},:\"'";
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (kBetween.find(c) == std::string_view::npos)
      words.back() += c;
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

bool means_sd(const std::string& word) {
  constexpr std::array<std::string_view, 6> all = {"sd", "std", "stdev", "sigma", "uncertainty", "s.d."};
  return std::ranges::find(all, word) != all.end();
}

std::string joined(std::span<const std::string> words, char between) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += between;
    text += word;
  }
  return text;
}

}  // namespace

Heading heading_of(std::string_view text) {
  Heading heading;
  std::vector<std::string> words = words_of(plain(text));
  const std::size_t all = words.size();
  std::erase_if(words, means_sd);
  heading.sd = words.size() < all;
  const std::span<const std::string> rest(words);
  std::size_t until = rest.size();
  for (std::size_t from = 1; from < rest.size() && heading.unit.empty(); ++from) {
    const std::string unit = joined(rest.subspan(from), '/');
    if (std::ranges::find(kUnits, unit, &Unit::name) == kUnits.end()) continue;
    heading.unit = unit;
    until = from;
  }
  heading.quantity = joined(rest.first(until), '_');
  return heading;
}

std::optional<double> si_per(std::string_view unit, Dimension dimension) {
  for (const Unit& known : kUnits)
    if (known.name == unit && known.dimension == dimension) return known.si;
  return std::nullopt;
}

}  // namespace tribotrack::apps
