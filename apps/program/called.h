// A command called as a function (Context::called): what lies in memory in place of its files, and its
// results, which then go neither to standard output nor, unless asked for, into files.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/text/csv_table.h"
#include "fit/json.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

struct Called {
  // Given.
  std::function<std::shared_ptr<vision::FrameSource>(double frame_rate_hz)> frames;  ///< of `track`
  /// A campaign's structure, or {"csv", "meta"}: the text of a track and the object of its meta file.
  fit::Json input;

  // Results.
  Columns columns;
  fit::Json object = fit::Json::object();
  std::vector<std::string> doubts;  ///< why the results should not be used as they are
};

}  // namespace tribotrack::apps
