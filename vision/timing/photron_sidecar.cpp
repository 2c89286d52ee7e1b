#include "vision/timing/photron_sidecar.h"

#include <array>
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

std::optional<TimeBaseCandidate> photron_sidecar_rate(const std::filesystem::path& recording) {
  struct Form {
    const char* extension;
    const char* key;
  };
  constexpr std::array<Form, 4> forms = {{{".cihx", "<recordRate>"},
                                          {".CIHX", "<recordRate>"},
                                          {".cih", "Record Rate(fps)"},
                                          {".CIH", "Record Rate(fps)"}}};
  for (const Form& form : forms) {
    std::filesystem::path beside = recording;
    beside.replace_extension(form.extension);
    std::ifstream file(beside, std::ios::binary);
    if (!file) continue;
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    const std::string source = "sidecar " + beside.filename().string();
    if (const auto rate = number_after(text, form.key))
      return TimeBaseCandidate{source, *rate, true, "written by the camera beside the recording"};
    return TimeBaseCandidate{source, 0, false,
                             std::string("no '") + form.key + "' with a positive number in it"};
  }
  return std::nullopt;
}

}  // namespace tribotrack::vision
