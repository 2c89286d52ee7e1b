// A self-contained HTML page: sections, figures that plotly.js draws, and what leaves the page as a file. It
// fetches nothing.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "apps/figures/figure.h"

namespace tribotrack::apps {

/// A part of the page with a heading and an entry in the list of contents.
struct PageSection {
  std::string id;       ///< anchor
  std::string heading;  ///< plain text
  std::string html;
  bool appendix = false;  ///< on paper behind a page break, from the first such section on
};

struct Page {
  std::string name;             ///< files saved from the page begin with it
  std::string title, subtitle;  ///< plain text
  std::string first = {};       ///< HTML of the first screen
  std::vector<PageSection> sections = {};
  std::vector<Figure> figures = {};  ///< all that figure_box() was called for
};

std::string html_of(Page page);

/// The place of a figure, with its title and caption below.
std::string figure_box(const Figure& figure);

/// The same for the figure of that id; empty where there is none.
std::string figure_box(const std::vector<Figure>& figures, const std::string& id);

using PageParts = std::map<std::string, std::string_view, std::less<>>;

/// Replaces each {{name}} of the template once, in one pass: what is put in is not looked at again. Throws
/// std::logic_error for a name that is not among the parts.
std::string fill_template(std::string_view page, const PageParts& parts);

/// JSON inside a script element: "<" occurs only inside strings, and written as an escape nothing in them can
/// close the element.
std::string json_for_script(const Json& json);

}  // namespace tribotrack::apps
