#include "apps/files/meta_file.h"

#include <fmt/format.h>

#include "apps/program/errors.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

Json MetaFile::json() const {
  Json meta;
  meta["program"] = "tribotrack";
  meta["version"] = TRIBOTRACK_VERSION;
  meta["schema"] = kSchemaVersion;
  meta["command"] = command;
  meta["inputs"] = Json::array();
  for (const Input& input : inputs) {
    meta["inputs"].push_back({{"path", input.path.string()}, {"xxh3_128", input.xxh3_128}});
    if (!input.hashed.empty()) meta["inputs"].back()["hashed"] = input.hashed;
  }
  meta["configuration"] = configuration;
  for (const auto& [key, value] : more.items()) meta[key] = value;
  return meta;
}

void MetaFile::write_beside(const fs::path& result) const {
  write_file(result.string() + ".meta.json", text_of(json()));
}

void require_known_schema(const Json& meta, const std::filesystem::path& file) {
  const auto schema = meta.find("schema");
  if (schema == meta.end() || !schema->is_number_integer() || *schema <= kSchemaVersion) return;
  throw InvalidInput(
      fmt::format("{}: `schema` is {}, written by a newer tribotrack; this one reads up to {}: update it, or "
                  "run the campaign again",
                  file.string(), schema->dump(), kSchemaVersion));
}

void write_result(const fs::path& path, std::string_view text, const MetaFile& meta) {
  if (is_standard_output(path)) return print_text(text);
  write_file(path, text);
  meta.write_beside(path);
}

Json json_of(const vision::TimeBase& time_base) {
  Json json;
  json["source"] = time_base.source;
  json["rate_hz"] = optional_json(time_base.rate_hz);
  json["stamps"] = !time_base.stamps_s.empty();
  json["candidates"] = Json::array();
  for (const auto& candidate : time_base.candidates)
    json["candidates"].push_back({{"source", candidate.source},
                                  {"rate_hz", candidate.rate_hz},
                                  {"accepted", candidate.accepted},
                                  {"reason", candidate.reason}});
  return json;
}

Json json_of(const std::vector<vision::PlanStage>& plan) {
  Json json = Json::array();
  for (const auto& stage : plan)
    json.push_back({{"stage", stage.name},
                    {"on", stage.on},
                    {"reason", stage.reason},
                    {"error_bound_px", stage.error_bound_px ? Json(*stage.error_bound_px) : Json()}});
  return json;
}

Json json_of(const std::vector<vision::SlowPart>& slow) {
  Json json = Json::array();
  for (const auto& part : slow)
    json.push_back({{"from", part.from}, {"sd_px", part.sd}, {"time_s", part.time}});
  return json;
}

Json json_of(const vision::Audit& audit) {
  return {{"halves_x", optional_json(audit.halves_x)},
          {"halves_y", optional_json(audit.halves_y)},
          {"high_frequency", optional_json(audit.high_frequency)},
          {"pixel_phase", optional_json(audit.pixel_phase)},
          {"lag1", optional_json(audit.lag1)},
          {"frames", audit.frames},
          {"white_factor", audit.white_factor},
          {"slow_sd_px", audit.slow_sd},
          {"slow_time_s", audit.slow_time}};
}

Json json_of(const vision::CodedErrors& coded) {
  Json types = Json::object();
  for (const auto& type : coded.types)
    types[std::string(1, type.type)] = {{"frames", type.frames},
                                        {"step_levels", type.step},
                                        {"still_share", type.still},
                                        {"added_sd_px", type.added_sd}};
  return {{"coder", coded.coder},
          {"settings", coded.settings},
          {"known", coded.known},
          {"frame_types", types},
          {"step_levels", coded.step},
          {"still_share", coded.still},
          {"moving_share", coded.moving},
          {"unnoticed_px", coded.unnoticed},
          {"part_play_px", coded.part_play},
          {"mark_play_px", coded.mark_play},
          {"added_sd_px", coded.added_sd},
          {"slow_time_s", coded.slow_time},
          {"passes_differ", coded.passes_differ}};
}

Json circle_json(const std::optional<vision::Circle>& circle) {
  return circle ? Json::array({circle->x, circle->y, circle->radius}) : Json();
}

Json rect_json(const std::optional<vision::Rect>& rect) {
  return rect ? Json::array({rect->x, rect->y, rect->width, rect->height}) : Json();
}

}  // namespace tribotrack::apps
