// The commit that the sources are from, written by commit.cmake at every build.
#pragma once

namespace tribotrack::apps {

/// "c812518", "c812518+" with changes that are not committed, "" where nobody knows.
const char* source_commit();

}  // namespace tribotrack::apps
