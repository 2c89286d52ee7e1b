#include "apps/survey/survey_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>
#include <set>

#include "apps/files/run_folder.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/page/page.h"
#include "apps/page/text.h"
#include "apps/text/angle.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

namespace {

enum class Unit { unknown, degrees, radians };

/// A number of a name: "045", "0.79rad", "60p5deg".
struct Written {
  std::string digits;  ///< with a decimal point
  Unit unit = Unit::unknown;
  double value() const { return std::stod(digits); }
};

const std::string kNumber = R"(([+-]?[0-9]+(?:[.,][0-9]+|p[0-9]+(?=[^0-9a-z]|$|deg|rad))?))";
const std::string kUnit = R"([ _]?(deg(?:rees)?|rad)?(?![a-z]))";

Written written(const std::string& number, const std::string& unit) {
  Written result{number, Unit::unknown};
  for (const char separator : {'p', ','}) std::ranges::replace(result.digits, separator, '.');
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

/// As a campaign writes it; empty where the unit is not known.
std::string settled(const std::optional<Written>& number, Unit common) {
  if (!number) return "";
  const Unit unit = number->unit == Unit::unknown ? common : number->unit;
  return unit == Unit::unknown ? ""
                               : fmt::format("{}{}", number->value(), unit == Unit::degrees ? "deg" : "");
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
    const bool slide = name.find("slide") != std::string::npos || name.find("incline") != std::string::npos;
    guesses.push_back(
        {settled(angles[k].phi, common), settled(angles[k].dtau, common), frame_rate_in(name), slide});
  }
  return guesses;
}

namespace {

struct RoleName {
  const char *word, *text;  ///< in JSON, and for people
};

RoleName name_of(vision::DiscRole role) {
  constexpr RoleName kNames[] = {{"part", "the part"},  // in the order of DiscRole
                                 {"like_part", "moves as the part may"},
                                 {"mark", "a mark on the platform"},
                                 {"resting", "at rest"}};
  return kNames[static_cast<int>(role)];
}

std::string motion_text(const vision::SurveyedDisc& disc, int looked_at) {
  std::string text =
      disc.moved_px > 0 ? fmt::format("moves by up to {:.1f} px", disc.moved_px) : "does not move";
  if (disc.seen_in < looked_at) text += fmt::format(", seen in {} of {} frames", disc.seen_in, looked_at);
  return text;
}

}  // namespace

std::string circle_text(const vision::Circle& c) {
  return fmt::format("[{:.1f}, {:.1f}, {:.1f}]", c.x, c.y, c.radius);
}

std::vector<std::string> descriptions(const vision::Survey& seen) {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < seen.discs.size(); ++k) {
    const vision::SurveyedDisc& disc = seen.discs[k];
    lines.push_back(fmt::format("disc {}: {}, ({:.1f}, {:.1f}) px, radius {:.1f} px, {}", k + 1,
                                name_of(disc.role).text, disc.circle.x, disc.circle.y, disc.circle.radius,
                                motion_text(disc, seen.frames_looked_at)));
  }
  for (std::size_t k = 0; k < seen.lamps.size(); ++k) {
    const vision::SurveyedLamp& lamp = seen.lamps[k];
    lines.push_back(
        fmt::format("LED L{}: ({:.1f}, {:.1f}) px, radius {:.1f} px, lit in {:.0f} % of the frames", k + 1,
                    lamp.circle.x, lamp.circle.y, lamp.circle.radius, 100 * lamp.lit_share));
  }
  if (seen.discs.empty())
    lines.emplace_back("no disc was found: a part of another shape is given by template_px");
  return lines;
}

std::string camera_section(const vision::Survey& seen, const vision::SourceInfo& info) {
  std::string text = "[camera]\n";
  const auto add = [&text](const char* key, const vision::Circle& circle, const std::string& why) {
    text += fmt::format("{:<36} # {}\n", fmt::format("{} = {}", key, circle_text(circle)), why);
  };
  if (!info.time_base.known())
    text += fmt::format("# frame_rate_hz =      # to be given: {}\n", info.time_base.why_unknown());
  if (const auto* part = seen.part())
    add("disc_px", part->circle, "disc 1, " + motion_text(*part, seen.frames_looked_at));
  if (const auto* mark = seen.mark())
    add("marker_px", mark->circle,
        fmt::format("disc {}, {}", mark - seen.discs.data() + 1, motion_text(*mark, seen.frames_looked_at)));
  if (!seen.lamps.empty())
    add("gate_px", seen.lamps.front().circle,
        fmt::format("LED L1, lit in {:.0f} % of the frames", 100 * seen.lamps.front().lit_share));
  return text;
}

Json json_of(const vision::Survey& seen) {
  Json discs = Json::array(), lamps = Json::array();
  for (const vision::SurveyedDisc& disc : seen.discs)
    discs.push_back({{"circle_px", circle_json(disc.circle)},
                     {"role", name_of(disc.role).word},
                     {"moved_px", disc.moved_px},
                     {"coverage", disc.coverage},
                     {"seen_in_frames", disc.seen_in}});
  for (const vision::SurveyedLamp& lamp : seen.lamps)
    lamps.push_back({{"circle_px", circle_json(lamp.circle)},
                     {"dark_level", lamp.dark},
                     {"lit_level", lamp.lit},
                     {"lit_share", lamp.lit_share}});
  return {
      {"frame", seen.frame}, {"frames_looked_at", seen.frames_looked_at}, {"discs", discs}, {"lamps", lamps}};
}

namespace {

constexpr int kFrames = 40;
constexpr int kLargestSide = 1280;

Json targets(const vision::Survey& seen) {
  const auto target = [](const char* key, const char* name, const char* colour, Json values) {
    return Json{
        {"key", key}, {"name", name}, {"colour", colour}, {"values", std::move(values)}, {"shape", "circle"}};
  };
  Json list = Json::array();
  list.push_back(target("disc_px", "The part, a disc", "#50ff50",
                        seen.part() ? circle_json(seen.part()->circle) : Json()));
  list.push_back(target("marker_px", "A mark on the platform", "#33bbff",
                        seen.mark() ? circle_json(seen.mark()->circle) : Json()));
  list.push_back(target("gate_px", "The gate LED", "#ff6060",
                        seen.lamps.empty() ? Json() : circle_json(seen.lamps.front().circle)));
  Json rectangle = target("template_px", "A part that is no disc", "#ffd040", Json());
  rectangle["shape"] = "rectangle";
  list.push_back(rectangle);
  return list;
}

/// Evenly spread, the survey's own among them.
std::set<std::int64_t> frames_to_show(const vision::SourceInfo& info, std::int64_t own) {
  std::set<std::int64_t> frames = {own};
  const std::int64_t count = std::min<std::int64_t>(kFrames, info.frame_count);
  for (std::int64_t k = 0; k < count; ++k)
    frames.insert(info.first_number + (count > 1 ? k * (info.frame_count - 1) / (count - 1) : 0));
  return frames;
}

}  // namespace

std::string survey_page(vision::FrameSource& source, const vision::Survey& seen) {
  const vision::SourceInfo& info = source.info();
  Json data = {{"width", info.width},     {"height", info.height},    {"targets", targets(seen)},
               {"frames", Json::array()}, {"numbers", Json::array()}, {"start", 0}};
  std::string head = camera_section({}, info);
  data["head"] = head;
  for (const std::int64_t frame : frames_to_show(info, seen.frame)) {
    if (frame == seen.frame) data["start"] = data["numbers"].size();
    data["frames"].push_back(base64(vision::first_frame_jpeg(source, frame, kLargestSide)));
    data["numbers"].push_back(frame);
  }
  const std::string title = escape_html(info.path.filename().string());
  const std::string subtitle =
      escape_html(fmt::format("{} x {} pixels, {} frames, numbers {} to {}", info.width, info.height,
                              info.frame_count, info.first_number, info.first_number + info.frame_count - 1));
  const std::string notes =
      fmt::format("<h2>What was found in frame {}</h2>\n{}", seen.frame, html_list(descriptions(seen)));
  const std::string json = json_for_script(data);
  const EmbeddedAssets& assets = embedded_assets();
  return fill_template(assets.frames_template, {{"title", title},
                                                {"subtitle", subtitle},
                                                {"style", assets.page_css},
                                                {"notes", notes},
                                                {"data", json},
                                                {"script", assets.frames_js}});
}

}  // namespace tribotrack::apps
