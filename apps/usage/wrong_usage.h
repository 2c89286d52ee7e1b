// What is wrong with a command line, in the words of whoever typed it.
#pragma once

#include <CLI/CLI.hpp>
#include <limits>
#include <string>
#include <vector>

namespace tribotrack::apps {

/// One sentence on a command line that CLI11 could not parse: the word that is wrong, and the command or
/// option that was probably meant. `typed` is the command line without the program's name.
std::string wrong_usage(const CLI::App& app, const CLI::ParseError& error,
                        const std::vector<std::string>& typed);

/// Accepts whole numbers from `least` to `most`, or without end; what else is given is told with both.
CLI::Validator whole_number(long least, long most = std::numeric_limits<long>::max());

/// Accepts these words; what else is given is told with them.
CLI::Validator one_of(const std::vector<std::string>& words);

}  // namespace tribotrack::apps
