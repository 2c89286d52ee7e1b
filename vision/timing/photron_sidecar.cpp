#include "vision/timing/photron_sidecar.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string_view>

namespace tribotrack::vision {
namespace {

/// The number behind `key` and any of the characters that separate them.
std::optional<double> number_after(std::string_view text, std::string_view key) {
  const auto found = text.find(key);
  if (found == std::string_view::npos) return std::nullopt;
  const auto begin = text.find_first_not_of(" \t:=", found + key.size());
  if (begin == std::string_view::npos) return std::nullopt;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data() + begin, text.data() + text.size(), number);
  if (error != std::errc{} || !(number > 0) || !std::isfinite(number)) return std::nullopt;
  return number;
}

}  // namespace

std::optional<std::filesystem::path> photron_sidecar(const std::filesystem::path& recording) {
  for (const char* extension : {".cihx", ".CIHX", ".cih", ".CIH"}) {
    std::filesystem::path beside = recording;
    beside.replace_extension(extension);
    if (std::ifstream(beside, std::ios::binary)) return beside;
  }
  return std::nullopt;
}

std::optional<TimeBaseCandidate> photron_sidecar_rate(const std::filesystem::path& recording) {
  const auto sidecar = photron_sidecar(recording);
  if (!sidecar) return std::nullopt;
  std::ifstream file(*sidecar, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::string source = "sidecar " + sidecar->filename().string();
  const bool is_xml = sidecar->extension().string().size() == 5;
  const std::string key = is_xml ? "<recordRate>" : "Record Rate(fps)";
  if (const auto rate = number_after(text, key))
    return TimeBaseCandidate{source, *rate, true, "written by the camera beside the recording"};
  return TimeBaseCandidate{source, 0, false, "no '" + key + "' with a positive number in it"};
}

}  // namespace tribotrack::vision
