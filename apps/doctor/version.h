// Which program this is.
#pragma once

#include <string>

namespace tribotrack::apps {

/// "tribotrack VERSION (c812518)" and a line with the versions of the libraries it was compiled with. The
/// commit is that of the sources, "+" where they were changed since; left out of builds that are not from a
/// repository.
std::string version_text();

}  // namespace tribotrack::apps
