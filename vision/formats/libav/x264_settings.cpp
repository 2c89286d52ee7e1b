#include "vision/formats/libav/x264_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>

namespace tribotrack::vision {
namespace {

using Settings = std::map<std::string, std::string>;

Settings parsed(const std::string& text) {
  Settings out;
  const auto begin = text.find("options:");
  std::istringstream words(begin == std::string::npos ? "" : text.substr(begin + 8));
  for (std::string word; words >> word;)
    if (const auto at = word.find('='); at != std::string::npos)
      out[word.substr(0, at)] = word.substr(at + 1);
  return out;
}

/// "0x3:0x113" holds masks; the second is that of inter frames, which allow what intra frames do.
std::string partitions(const std::string& masks) {
  const auto at = masks.find(':');
  const long inter = std::strtol(masks.c_str() + (at == std::string::npos ? 0 : at + 1), nullptr, 16);
  std::string out;
  const auto add = [&](long bit, const char* name) {
    if ((inter & bit) != 0) out += fmt::format("{}{}", out.empty() ? "" : ",", name);
  };
  add(0x1, "i4x4");
  add(0x2, "i8x8");
  add(0x10, "p8x8");
  add(0x20, "p4x4");
  add(0x100, "b8x8");
  return out.empty() ? "none" : out;
}

/// After the first ':' or ','.
std::string second(const std::string& pair) {
  const auto at = pair.find_first_of(":,");
  return at == std::string::npos ? pair : pair.substr(at + 1);
}

std::string first(const std::string& pair) {
  return pair.substr(0, pair.find_first_of(":,"));
}

double number(const Settings& settings, const char* name, double otherwise) {
  const auto found = settings.find(name);
  return found == settings.end() ? otherwise : std::atof(found->second.c_str());
}

std::string rate(const Settings& settings) {
  const auto how = settings.find("rc");
  if (how != settings.end() && how->second == "crf")
    return fmt::format("crf={:.2f}", number(settings, "crf", 23));
  if (how != settings.end() && how->second == "cqp")
    return fmt::format("qp={:.0f}", number(settings, "qp", 23));
  return "crf=23";
}

}  // namespace

std::string x264_parameters(const std::string& text) {
  const Settings settings = parsed(text);
  static const std::set<std::string> as_they_are = {
      "cabac",    "ref",           "me",        "subme",      "psy",          "me_range",
      "trellis",  "8x8dct",        "nr",        "bframes",    "b_pyramid",    "b_adapt",
      "b_bias",   "weightb",       "weightp",   "open_gop",   "keyint",       "keyint_min",
      "scenecut", "intra_refresh", "chroma_me", "fast_pskip", "rc_lookahead", "mbtree",
      "qcomp",    "qpmin",         "qpmax",     "qpstep",     "psy_rd",       "constrained_intra"};
  std::string out = rate(settings);
  const auto add = [&](const std::string& name, const std::string& value) {
    out += fmt::format(":{}={}", name, value);
  };
  for (const auto& [name, value] : settings) {
    if (as_they_are.contains(name)) {
      // A colon ends an option of libav's.
      add(name, name == "psy_rd" ? first(value) + "," + second(value) : value);
    } else if (name == "deblock") {
      if (first(value) == "0")
        add("no-deblock", "1");
      else
        add("deblock", first(second(value)) + "," + second(second(value)));
    } else if (name == "analyse") {
      add("partitions", partitions(value));
    } else if (name == "mixed_ref") {
      add("mixed-refs", value);
    } else if (name == "deadzone") {
      add("deadzone-inter", first(value));
      add("deadzone-intra", second(value));
    } else if (name == "decimate") {
      add("dct-decimate", value);
    } else if (name == "direct") {
      static const char* const names[] = {"none", "spatial", "temporal", "auto"};
      add("direct", names[std::clamp(std::atoi(value.c_str()), 0, 3)]);
    } else if (name == "ip_ratio") {
      add("ipratio", value);
    } else if (name == "pb_ratio") {
      add("pbratio", value);
    } else if (name == "aq") {
      add("aq-mode", first(value));
      if (first(value) != "0") add("aq-strength", second(value));
    }
  }
  return out;
}

int b_frames_of(const std::string& settings) {
  return static_cast<int>(number(parsed(settings), "bframes", 0));
}

}  // namespace tribotrack::vision
