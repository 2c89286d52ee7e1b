// The report of a campaign: one self-contained HTML page, tables for other programs, a text to paste, figures
// for print.
#pragma once

#include <string>
#include <vector>

#include "apps/files/run_folder.h"

namespace tribotrack::apps {

struct Report {
  std::string page;  ///< HTML
  std::string runs_csv, parameters_csv, text;
  std::vector<std::string> figures;  ///< of the campaign, not of its single runs: their ids
  std::vector<std::string>
      missing;  ///< what it does not show since the file is gone; stands on the page, too
};

/// Of a folder that `run` has filled. Throws InvalidInput.
Report report_of(const RunFolder& folder);

}  // namespace tribotrack::apps
