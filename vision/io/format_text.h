// Short texts with numbers in them, as printf writes them.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace tribotrack::vision {

std::string format(const char* pattern, auto... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

}  // namespace tribotrack::vision
