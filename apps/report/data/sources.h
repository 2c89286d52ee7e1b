// The parts of the report that are filled the same way from results in memory and from the files of a run.
#pragma once

#include "apps/files/run_folder.h"
#include "apps/files/track_file.h"
#include "apps/report/data/data.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// Title, version, inputs, effective configuration and what it gave, from what stands beside fit.json.
/// `data.parameters` must be filled in. Throws WrongContent.
void add_provenance(const Json& meta, ReportData& data);

/// The track's path, counts, time base, notes and plan, and its first frame's picture from the folder.
void add_track(const Track& track, const RunFolder& folder, ReportRun& run);

/// A run that is the mean of several lines of a table says so.
void add_pooled_note(const std::vector<std::string>& lines, ReportRun& run);

/// The recording by its hash.
void add_recording(const Track& track, ReportData& data);

// The part of the report that comes out of fit.json.

/// Everything of `fit` but its runs. What an older file lacks stays absent on the page. Throws WrongContent
/// where a key that every fit.json holds is missing or of the wrong kind.
void read_fit(const Json& fit, ReportData& data);

/// The array `budget`. After the parameters.
void read_budget(const JsonPlace& budget, ReportData& data);

/// The array `conditions`.
void read_conditions(const JsonPlace& conditions, ReportData& data);

}  // namespace tribotrack::apps
