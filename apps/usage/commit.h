// Which program this is: its sources, written by commit.cmake at every build, and what it finds here.
#pragma once

#include <map>
#include <string>

namespace tribotrack::apps {

/// "c812518", "c812518+" with changes that are not committed, "" where nobody knows.
const char* source_commit();

/// Of each stage (track, measure, fit, report) the hash of the sources that make its results: another one may
/// give others.
const std::map<std::string, std::string>& source_revisions();

/// "tribotrack VERSION (c812518)", a line with the versions of the libraries it was compiled with, and one
/// each on the threads it would use and on temporary files. The commit is that of the sources, "+" where they
/// were changed since; left out of builds that are not from a repository.
std::string version_text();

}  // namespace tribotrack::apps
