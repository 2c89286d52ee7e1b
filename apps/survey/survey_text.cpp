#include "apps/survey/survey_text.h"

#include <fmt/format.h>

namespace tribotrack::apps {

namespace {

const char* role_text(vision::DiscRole role) {
  switch (role) {
    case vision::DiscRole::part:
      return "the part";
    case vision::DiscRole::mark:
      return "a mark on the platform";
    case vision::DiscRole::like_part:
      return "moves as the part may";
    case vision::DiscRole::resting:
      break;
  }
  return "at rest";
}

const char* role_word(vision::DiscRole role) {
  switch (role) {
    case vision::DiscRole::part:
      return "part";
    case vision::DiscRole::mark:
      return "mark";
    case vision::DiscRole::like_part:
      return "like_part";
    case vision::DiscRole::resting:
      break;
  }
  return "resting";
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
                                role_text(disc.role), disc.circle.x, disc.circle.y, disc.circle.radius,
                                motion_text(disc, seen.frames_looked_at)));
  }
  for (std::size_t k = 0; k < seen.lamps.size(); ++k) {
    const vision::SurveyedLamp& lamp = seen.lamps[k];
    lines.push_back(
        fmt::format("lamp L{}: ({:.1f}, {:.1f}) px, radius {:.1f} px, lit in {:.0f} % of the frames", k + 1,
                    lamp.circle.x, lamp.circle.y, lamp.circle.radius, 100 * lamp.lit_share));
  }
  if (seen.discs.empty())
    lines.emplace_back("no disc was found: a part of another shape is given by template_px");
  return lines;
}

std::vector<CampaignLine> places(const vision::Survey& seen) {
  std::vector<CampaignLine> lines;
  if (const auto* part = seen.part())
    lines.push_back(
        {"disc_px", circle_text(part->circle), "disc 1, " + motion_text(*part, seen.frames_looked_at)});
  if (const auto* mark = seen.mark())
    lines.push_back({"marker_px", circle_text(mark->circle),
                     fmt::format("disc {}, {}", mark - seen.discs.data() + 1,
                                 motion_text(*mark, seen.frames_looked_at))});
  if (!seen.lamps.empty())
    lines.push_back(
        {"gate_px", circle_text(seen.lamps.front().circle),
         fmt::format("lamp L1, lit in {:.0f} % of the frames", 100 * seen.lamps.front().lit_share)});
  return lines;
}

std::string camera_section(const vision::Survey& seen, const vision::SourceInfo& info) {
  std::string text = "[camera]\n";
  if (!info.time_base.known())
    text += fmt::format("# frame_rate_hz =      # to be given: {}\n", info.time_base.why_unknown());
  for (const CampaignLine& line : places(seen))
    text += fmt::format("{:<36} # {}\n", line.key + " = " + line.value, line.why);
  return text;
}

Json json_of(const vision::Survey& seen) {
  const auto circle = [](const vision::Circle& c) { return Json::array({c.x, c.y, c.radius}); };
  Json discs = Json::array(), lamps = Json::array();
  for (const vision::SurveyedDisc& disc : seen.discs)
    discs.push_back({{"circle_px", circle(disc.circle)},
                     {"role", role_word(disc.role)},
                     {"moved_px", disc.moved_px},
                     {"coverage", disc.coverage},
                     {"seen_in_frames", disc.seen_in}});
  for (const vision::SurveyedLamp& lamp : seen.lamps)
    lamps.push_back({{"circle_px", circle(lamp.circle)},
                     {"dark_level", lamp.dark},
                     {"lit_level", lamp.lit},
                     {"lit_share", lamp.lit_share}});
  return {
      {"frame", seen.frame}, {"frames_looked_at", seen.frames_looked_at}, {"discs", discs}, {"lamps", lamps}};
}

}  // namespace tribotrack::apps
