#include "apps/pipeline/manifest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "apps/program/errors.h"
#include "apps/usage/commit.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string seen_from(const fs::path& folder, const fs::path& file) {
  const fs::path relative = fs::weakly_canonical(file).lexically_relative(fs::weakly_canonical(folder));
  return relative.empty() ? file.string() : relative.string();
}

/// As it was hashed: whole, or a sample of what is large.
std::string hash_of(const fs::path& file, bool sampled) {
  Sampling sampling;
  if (!sampled) sampling.whole_up_to = std::numeric_limits<std::uint64_t>::max();
  return hash_of_files(files_of_input(file), sampling).xxh3_128;
}

/// "changed" or "gone"; empty where the file is as it was.
std::string change_of(const fs::path& file, const JsonPlace& entry) {
  if (!may_be_recording(file)) return "gone";
  try {
    return hash_of(file, !entry.text("hashed").empty()) == entry.text("xxh3_128") ? "" : "changed";
  } catch (const InvalidInput&) {
    return "gone";
  }
}

std::size_t compare(const RunFolder& folder, std::vector<std::string>& differ) {
  if (const auto writer = writer_of(folder))
    throw InvalidInput(
        fmt::format("{}: is being written by {}; wait until it has finished", folder.root.string(), *writer));
  const Json json = read_json(folder.log());
  if (!json.is_object() || !json.contains("manifest"))
    throw InvalidInput(
        fmt::format("{}: holds no manifest: an older tribotrack wrote it; run the campaign again",
                    folder.log().string()));
  std::size_t count = 0;
  try {
    for (const char* kind : {"inputs", "outputs"})
      for (const JsonPlace& entry : JsonPlace{json, ""}.at("manifest").items(kind)) {
        const fs::path file = folder.root / entry.at("path").text();
        if (const std::string change = change_of(file, entry); !change.empty())
          differ.push_back(fmt::format("{} ({})", file.lexically_normal().string(), change));
        ++count;
      }
  } catch (const WrongContent& error) {
    throw InvalidInput(fmt::format("{}: holds no manifest that can be read ({}); run the campaign again",
                                   folder.log().string(), error.what()));
  }
  return count;
}

}  // namespace

Json manifest_of(const RunFolder& folder, const std::vector<std::string>& runs,
                 const std::vector<Input>& inputs) {
  Json json = {
      {"version", TRIBOTRACK_VERSION}, {"commit", source_commit()}, {"revisions", source_revisions()}};
  const auto entry = [&](const Input& file) {
    Json one = {{"path", seen_from(folder.root, file.path)}, {"xxh3_128", file.xxh3_128}};
    if (!file.hashed.empty()) one["hashed"] = file.hashed;
    return one;
  };
  json["inputs"] = Json::array();
  for (const Input& input : inputs)
    if (const Json one = entry(input); std::ranges::count(json["inputs"], one) == 0)
      json["inputs"].push_back(one);
  std::vector<fs::path> files = {folder.fit(),        folder.fit().string() + ".meta.json",
                                 folder.report(),     folder.text(),
                                 folder.runs_table(), folder.parameter_table()};
  for (const std::string& run : runs)
    for (const fs::path& file : folder.files_of(run)) files.push_back(file);
  json["outputs"] = Json::array();
  for (const fs::path& file : files) json["outputs"].push_back(entry(hashed_input(file)));
  return json;
}

std::size_t verify(const fs::path& folder) {
  std::vector<std::string> differ;
  std::size_t count = 0, manifests = 0;
  std::vector<fs::path> folders = {folder};
  std::error_code none;
  for (const auto& inner : fs::directory_iterator(folder, none)) folders.push_back(inner.path());
  std::sort(folders.begin() + 1, folders.end());
  for (const fs::path& one : folders) {
    if (!fs::is_regular_file(RunFolder{one}.log()) || (manifests > 0 && fs::exists(RunFolder{folder}.log())))
      continue;
    count += compare({one}, differ);
    ++manifests;
  }
  if (manifests == 0)
    throw InvalidInput(
        fmt::format("{}: has no run.json; give a folder that `tribotrack run` has filled", folder.string()));
  if (!differ.empty())
    throw InvalidInput(fmt::format(
        "{}: {} of {} files are not those of its run: {}; run the campaign again, or put back what was there",
        folder.string(), differ.size(), count, fmt::join(differ, ", ")));
  return count;
}

}  // namespace tribotrack::apps
