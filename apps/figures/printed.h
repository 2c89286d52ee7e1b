// Figures as files for print: SVG and PDF in the widths of one and of two columns of a journal, 84 and 174
// mm, drawn from runs.csv by one script of matplotlib, which stays beside them.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace tribotrack::apps {

/// What print_figures() may write into `folder`: figures.py, runs.csv, and each figure as NAME-84mm and
/// NAME-174mm, .svg and .pdf. A figure that has no runs to show is left out.
std::vector<std::filesystem::path> printed_files(const std::filesystem::path& folder);

/// Writes table and script, and runs the script. Throws InvalidInput with what to install where there is no
/// python3 with matplotlib; table and script are then there all the same.
void print_figures(const std::filesystem::path& folder, std::string_view runs_csv, std::string_view script);

}  // namespace tribotrack::apps
