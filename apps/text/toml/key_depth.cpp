#include "apps/text/toml/key_depth.h"

#include <fmt/format.h>

#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

constexpr int kDeepest = 32;

bool may_stand_in_key(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' ||
         c == '"' || c == '\'' || c == ' ' || c == '\t';
}

}  // namespace

void require_shallow_keys(std::string_view text, const std::string& name) {
  int line = 1, dots = 0;
  std::size_t line_begin = 0, key_begin = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '.' && at > 0 && text[at - 1] != '.') {  // "..." is no key
      if (++dots < kDeepest) continue;
      throw InvalidInput(fmt::format("{}:{}:{}: a key of more than {} parts; keys here have at most 3", name,
                                     line, key_begin - line_begin + 1, kDeepest));
    }
    if (may_stand_in_key(c)) continue;
    dots = 0;
    key_begin = at + 1;
    if (c != '\n') continue;
    ++line;
    line_begin = at + 1;
  }
}

}  // namespace tribotrack::apps
