// The files of pages and workflows, the manual and the conditions of the paper's figures, carried inside the
// program so that an installed binary needs nothing beside it.
#pragma once

#include <span>
#include <string_view>

namespace tribotrack::apps {

/// The bytes of this folder as they were at build time (see embed_assets.cmake). Valid for the whole program.
struct EmbeddedAssets {
  std::string_view plotly_js;      ///< plotly.js, cartesian bundle, pinned in this folder/package.json
  std::string_view page_template;  ///< this folder/page.html, with {{name}} where a page's parts go
  std::string_view page_css;
  std::string_view page_js;
  std::string_view figures_js;       ///< draws figures on the page
  std::string_view figures_py;       ///< draws them for print
  std::string_view frames_template;  ///< this folder/frames.html: frames to scrub and to point into
  std::string_view frames_js;
  std::string_view open_html, open_css,
      open_js;                     ///< apps/open/assets: the page of `open`, on page_css and frames_js
  std::string_view snakefile;      ///< apps/workflow/Snakefile
  std::string_view slurm_profile;  ///< apps/workflow/slurm.yaml
  std::string_view slurm_status;   ///< apps/workflow/slurm_status.sh
};

const EmbeddedAssets& embedded_assets();

/// The conditions of a figure of the paper: data/NAME.toml.
struct EmbeddedScenario {
  std::string_view name;  ///< "figure6a"
  std::string_view toml;
};

/// All of data/figure*.toml, by name.
std::span<const EmbeddedScenario> paper_scenarios();

/// A page of the manual: apps/manual/NAME.md, which begins with "# Title".
struct ManualPage {
  std::string_view name;  ///< "start-here"
  std::string_view text;
};

/// All of apps/manual/*.md, by name.
std::span<const ManualPage> manual_pages();

}  // namespace tribotrack::apps
