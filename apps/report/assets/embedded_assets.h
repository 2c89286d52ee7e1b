// The report page's files, carried inside the program so that an installed binary needs nothing beside it.
#pragma once

#include <string_view>

namespace tribotrack::apps {

/// The bytes of this folder as they were at build time (see embed_assets.cmake). Valid for the whole program.
struct EmbeddedAssets {
  std::string_view plotly_js;      ///< plotly.js, cartesian bundle, pinned in this folder/package.json
  std::string_view page_template;  ///< this folder/page.html, with {{name}} where the report's parts go
  std::string_view report_css;
  std::string_view report_js;
};

const EmbeddedAssets& embedded_assets();

}  // namespace tribotrack::apps
