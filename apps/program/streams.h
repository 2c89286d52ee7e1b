// Standard output, whose failures are errors, and standard error, whose failures are ignored.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace tribotrack::apps {

/// Standard output takes no more: a full disk, or it is closed. Exit 1.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Without what controls a terminal, `?` in its place: texts repeat what a recording or a file name holds.
std::string printable(std::string_view text);

/// Results, printable, to stdout. Throws WriteError.
void print_text(std::string_view text);

template <class... Values>
void print(fmt::format_string<Values...> format, Values&&... values) {
  print_text(fmt::format(format, std::forward<Values>(values)...));
}

/// Throws WriteError unless everything printed so far has been taken. Called once, before the program ends.
void flush_output();

/// A line for people, printable, to stderr. Failures are ignored: there is nowhere left to report them.
void print_error(std::string_view line);

/// "tribotrack: message" on stderr.
void complain(std::string_view message);

/// Where the program was started without stdin, stdout or stderr, the next file opened would take the free
/// number, and messages would go into it. Takes these numbers first. main() calls it before anything else.
void occupy_standard_streams();

}  // namespace tribotrack::apps
