#include "apps/files/marker_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>

namespace tribotrack::apps {

namespace {

using Kind = vision::MarkerChoice::Kind;

vision::MarkerChoice tag_named(const std::string& name) {
  vision::MarkerChoice marker{Kind::tag, {}};
  const auto colon = name.find(':');
  marker.dictionary = name.substr(0, colon);
  vision::require_tag_family(marker.dictionary);
  if (colon == std::string::npos) return marker;
  const std::string number = name.substr(colon + 1);
  const bool whole = !number.empty() && number.size() < 5 &&
                     std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!whole)
    throw std::invalid_argument(fmt::format("a tag's number is a whole number, not \"{}\"", number));
  marker.id = std::stoi(number);
  return marker;
}

}  // namespace

std::optional<vision::MarkerChoice> marker_named(const std::string& word) {
  if (word == "auto") return vision::MarkerChoice{Kind::find, {}};
  if (word == "texture") return vision::MarkerChoice{Kind::texture, {}};
  if (word == "none") return vision::MarkerChoice{Kind::none, {}};
  if (word.starts_with("tag:")) return tag_named(word.substr(4));
  return std::nullopt;
}

std::string tag_word(const vision::MarkerChoice& marker) {
  return "tag:" + marker.dictionary + (marker.id ? fmt::format(":{}", *marker.id) : "");
}

}  // namespace tribotrack::apps
