#include "apps/text/json.h"

#include <fmt/format.h>

#include <fstream>

#include "apps/program/errors.h"

namespace tribotrack::apps {

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json read_json(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InvalidInput(fmt::format("{}: cannot be read; check its name", path.string()));
  try {
    return Json::parse(stream);
  } catch (const Json::exception& error) {
    throw InvalidInput(fmt::format("{}: is not a JSON file: {}", path.string(), error.what()));
  }
}

}  // namespace tribotrack::apps
