// Which program this is, and what it finds here.
#pragma once

#include <string>

namespace tribotrack::apps {

/// "tribotrack VERSION (c812518)", a line with the versions of the libraries it was compiled with, and one
/// each on the threads it would use and on temporary files. The commit is that of the sources, "+" where they
/// were changed since; left out of builds that are not from a repository.
std::string version_text();

}  // namespace tribotrack::apps
