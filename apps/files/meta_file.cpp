#include "apps/files/meta_file.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>

#include "apps/program/errors.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

void add_file(XXH3_state_t* state, const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream)
    throw InvalidInput(fmt::format("{}: cannot be read; check its name and permissions", path.string()));
  std::vector<char> block(1 << 20);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0)
    XXH3_128bits_update(state, block.data(), static_cast<std::size_t>(stream.gcount()));
}

/// The files a recording consists of: itself, the pictures in a folder, or those in the folder of a pattern.
std::vector<fs::path> files_of(const fs::path& path) {
  const bool pattern = !fs::exists(path) && path.filename().string().find('%') != std::string::npos;
  const fs::path folder = pattern ? (path.has_parent_path() ? path.parent_path() : fs::path(".")) : path;
  if (!fs::is_directory(folder)) return {path};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && (!pattern || entry.path().extension() == path.extension()))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::string hash_of_input(const fs::path& path) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  for (const fs::path& file : files_of(path)) add_file(state.get(), file);
  const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

Json MetaFile::json() const {
  Json meta;
  meta["program"] = "tribotrack";
  meta["version"] = TRIBOTRACK_VERSION;
  meta["schema"] = kSchemaVersion;
  meta["command"] = command;
  meta["inputs"] = Json::array();
  for (const fs::path& input : inputs)
    meta["inputs"].push_back({{"path", input.string()}, {"xxh3_128", hash_of_input(input)}});
  meta["configuration"] = configuration;
  for (const auto& [key, value] : more.items()) meta[key] = value;
  return meta;
}

void MetaFile::write_beside(const fs::path& result) const {
  write_file(result.string() + ".meta.json", text_of(json()));
}

Json json_of(const vision::TimeBase& time_base) {
  Json json;
  json["source"] = time_base.source;
  json["rate_hz"] = time_base.rate_hz ? Json(*time_base.rate_hz) : Json();
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
                    {"predicted_saving", stage.predicted_saving},
                    {"error_bound_px", stage.error_bound_px}});
  return json;
}

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json read_json(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InvalidInput(fmt::format("{}: cannot be read; check its name", path.string()));
  try {
    return Json::parse(stream);
  } catch (const Json::parse_error& error) {
    throw InvalidInput(fmt::format("{}: is not a JSON file: {}", path.string(), error.what()));
  }
}

}  // namespace tribotrack::apps
