#include "apps/files/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>

#include "apps/program/errors.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

constexpr int kSchemaVersion = 1;  ///< of the result files; stands in their meta files

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
      "{}: `schema` is {}, written by a newer tribotrack; this one reads up to {}: update it, or run the "
      "campaign again",
      file.string(), schema->dump(), kSchemaVersion);
}

void write_result(const fs::path& path, std::string_view text, const MetaFile& meta) {
  if (is_standard_output(path)) return print_text(text);
  write_file(path, text);
  MetaFile with_hash = meta;
  with_hash.more["result_xxh3_128"] = hash_of_text(text);
  with_hash.write_beside(path);
}

Json json_of(const vision::SourceInfo& info, const std::vector<std::int64_t>& repeats, bool weaved) {
  const vision::TimeBase& time_base = info.time_base;
  Json json;
  json["source"] = json["from"] = time_base.source;
  json["rate_hz"] = optional_json(time_base.rate_hz);
  json["stamps"] = !time_base.stamps_s.empty();
  json["gaps"] = Json::array();
  for (const auto& gap : time_base.check.missing) json["gaps"].push_back(info.first_number + gap.after);
  json["missing"] = time_base.check.missing_frames();
  json["repeats"] = repeats;
  json["fields"] = weaved ? Json("weaved") : Json();
  json["rotation_deg"] = info.rotation_deg;
  json["pixel_aspect"] = info.pixel_aspect;
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
          {"frames", audit.frames},
          {"white_factor", audit.white_factor},
          {"slow_sd_px", audit.slow_sd},
          {"slow_time_s", audit.slow_time}};
}

Json json_of(const vision::CodedErrors& coded) {
  return {{"coder", coded.coder},
          {"settings", coded.settings},
          {"known", coded.known},
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

namespace {

std::string this_process(const fs::path& campaign) {
  utsname host{};
  ::uname(&host);
  return fmt::format("process {} on {} (campaign {})", ::getpid(), host.nodename, campaign.string());
}

/// What the holder wrote into its lock.
std::string holder_in(const fs::path& file) {
  std::ifstream stream(file);
  std::string holder;
  std::getline(stream, holder);
  return holder.empty() ? "another process" : holder;
}

/// Is the open file still the one of that name? Whoever ends removes its lock file.
bool is_current(int descriptor, const fs::path& file) {
  struct stat open {
  }, named{};
  return ::fstat(descriptor, &open) == 0 && ::stat(file.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

}  // namespace

std::vector<std::string> RunFolder::runs() const {
  std::vector<std::string> names;
  std::error_code ignored;
  constexpr std::string_view kMeta = ".csv.meta.json";
  for (const auto& entry : fs::directory_iterator(tracks(), ignored)) {
    const std::string file = entry.path().filename().string();
    if (file.ends_with(kMeta) && !file.starts_with('.'))
      names.push_back(file.substr(0, file.size() - kMeta.size()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<fs::path> RunFolder::files_of(const std::string& run) const {
  std::vector<fs::path> files;
  for (const fs::path& file : {first_frame(run), overlay(run), measurement(run), track(run),
                               fs::path(track(run).string() + ".meta.json")})
    if (fs::exists(file)) files.push_back(file);
  return files;
}

std::vector<fs::path> RunFolder::files_of_report() const {
  std::vector<fs::path> files = {fit(), fit().string() + ".meta.json", log()};
  std::error_code ignored;
  for (const fs::path& folder : {tracks(), measurements()})
    for (const auto& entry : fs::directory_iterator(folder, ignored)) files.push_back(entry.path());
  return files;
}

RunFolderLock::RunFolderLock(const RunFolder& folder, const fs::path& campaign, bool wait)
    : file_(folder.lock()) {
  while (true) {
    create_folder(folder.root);
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
      if (errno == ENOENT) continue;  // its folder was removed by a run that came to nothing
      throw InvalidInput("{}: cannot be written: {}; give a folder that is yours to write to", file_.string(),
                         std::strerror(errno));
    }
    if (::flock(descriptor_, wait ? LOCK_EX : LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(descriptor_);
      throw InvalidInput(
          "{}: another run is writing there: {}; wait until it has finished (--wait), or give another folder",
          folder.root.string(), holder_in(file_));
    }
    // A file system without locks: better without one than not at all.
    if (is_current(descriptor_, file_)) break;
    ::close(descriptor_);
  }
  create_folder(folder.tracks());
  create_folder(folder.measurements());
  const std::string holder = this_process(campaign) + "\n";
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::write(descriptor_, holder.data(), holder.size()) != static_cast<::ssize_t>(holder.size())) {
    const std::string reason = std::strerror(errno);
    ::close(descriptor_);
    throw InvalidInput("{}: cannot be written: {}; make room there, or give another folder", file_.string(),
                       reason);
  }
}

RunFolderLock::~RunFolderLock() {
  std::error_code ignored;
  fs::remove(file_, ignored);
  const RunFolder folder{file_.parent_path()};
  for (const fs::path& empty : {folder.measurements(), folder.tracks(), folder.root})
    fs::remove(empty, ignored);
  ::close(descriptor_);
}

std::optional<std::string> writer_of(const RunFolder& folder) {
  const int descriptor = ::open(folder.lock().c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return std::nullopt;
  const bool held = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  if (!held) return std::nullopt;
  return holder_in(folder.lock());
}

}  // namespace tribotrack::apps
