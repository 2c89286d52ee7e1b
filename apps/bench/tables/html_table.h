// A benchmark's table on its page.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tribotrack::bench {

struct HtmlCell {
  std::string text;        ///< plain text
  std::string exact = {};  ///< all digits, for the file that a reader saves; empty: the text
  bool number = false;     ///< to the right
};

/// `headings` in plain text. Letters, digits, '-' and '_' of `id` name the file that a reader saves.
std::string html_table(std::string_view id, const std::vector<HtmlCell>& headings,
                       const std::vector<std::vector<HtmlCell>>& rows);

}  // namespace tribotrack::bench
