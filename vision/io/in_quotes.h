// File names in messages.
#pragma once

#include <filesystem>
#include <string>

namespace tribotrack::vision {

inline std::string in_quotes(const std::filesystem::path& path) {
  std::string text(1, '\'');
  text += path.string();
  text += '\'';
  return text;
}

}  // namespace tribotrack::vision
