// Which sources this program was made from, written by commit.cmake at every build.
#pragma once

#include <map>
#include <string>

namespace tribotrack::apps {

/// "c812518", "c812518+" with changes that are not committed, "" where nobody knows.
const char* source_commit();

/// Of each stage (track, measure, fit, report) the hash of the sources that make its results: another one may
/// give others.
const std::map<std::string, std::string>& source_revisions();

}  // namespace tribotrack::apps
