// Figures as files for print: SVG and PDF in the widths of one and of two columns of a journal, 84 and 174
// mm, drawn by matplotlib, with the numbers and the script beside them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/figures/figure.h"

namespace tribotrack::apps {

/// What print_figures() writes into `folder`: figures.py, and for each figure ID.csv, ID.json and ID-84mm and
/// ID-174mm as .svg and .pdf.
std::vector<std::filesystem::path> printed_files(const std::vector<Figure>& figures,
                                                 const std::filesystem::path& folder);

/// Why no figure could be drawn for print; empty where one can.
std::string why_not_printed();

/// Writes numbers and script, and runs the script. Throws InvalidInput with what to install where there is no
/// python3 with matplotlib; the numbers and the script are then there all the same.
void print_figures(const std::vector<Figure>& figures, const std::filesystem::path& folder,
                   std::string_view script);

}  // namespace tribotrack::apps
