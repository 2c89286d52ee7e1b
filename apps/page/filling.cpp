#include "apps/page/filling.h"

#include <stdexcept>

namespace tribotrack::apps {

std::string fill_template(std::string_view page, const PageParts& parts) {
  std::string filled;
  std::size_t position = 0;
  while (true) {
    const std::size_t open = page.find("{{", position);
    if (open == std::string_view::npos) break;
    const std::size_t close = page.find("}}", open);
    const auto part = parts.find(page.substr(open + 2, close - open - 2));
    if (close == std::string_view::npos || part == parts.end())
      throw std::logic_error("a page's template names a part that the page does not have");
    filled += page.substr(position, open - position);
    filled += part->second;
    position = close + 2;
  }
  return filled += page.substr(position);
}

std::string json_for_script(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

}  // namespace tribotrack::apps
