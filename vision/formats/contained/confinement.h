// What a process that decodes strangers' recordings may do.
#pragma once

#include <cstdint>
#include <string>

namespace tribotrack::vision {

/// Confines the calling process for good: it may open files to read them and take up to 4 GB beyond what it
/// has; it starts no process and reaches no network (seccomp, where the kernel has it). Descriptors from
/// `first_closed` on are closed, what is printed is lost.
void confine_to_reading(int first_closed);

/// The process dies after this much CPU time from now on, unless this is called again.
void allow_cpu(std::uint64_t seconds);

/// How a process that should not have ended did: "crashes its decoder ...", to follow a recording's name.
std::string end_in_words(int status);

}  // namespace tribotrack::vision
