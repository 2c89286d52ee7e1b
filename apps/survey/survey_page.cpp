#include "apps/survey/survey_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "apps/page/assets/embedded_assets.h"
#include "apps/page/filling.h"
#include "apps/page/text.h"
#include "apps/survey/survey_text.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

namespace {

constexpr int kFrames = 40;
constexpr int kLargestSide = 1280;

Json numbers(const vision::Circle& c) {
  return Json::array({c.x, c.y, c.radius});
}

Json targets(const vision::Survey& seen) {
  const auto target = [](const char* key, const char* name, const char* colour, Json values) {
    return Json{{"key", key},
                {"name", name},
                {"colour", colour},
                {"values", std::move(values)},
                {"rectangle", false}};
  };
  Json list = Json::array();
  list.push_back(
      target("disc_px", "The part, a disc", "#50ff50", seen.part() ? numbers(seen.part()->circle) : Json()));
  list.push_back(target("marker_px", "A mark on the platform", "#33bbff",
                        seen.mark() ? numbers(seen.mark()->circle) : Json()));
  list.push_back(target("gate_px", "The actuator's lamp", "#ff6060",
                        seen.lamps.empty() ? Json() : numbers(seen.lamps.front().circle)));
  Json rectangle = target("template_px", "A part that is no disc", "#ffd040", Json());
  rectangle["rectangle"] = true;
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
