// What can go wrong, as the shell sees it.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace tribotrack::apps {

enum ExitCode {
  kDone = 0,
  kUnexpected = 1,
  kUsage = 2,
  kInvalidInput = 3,
  kQualityGate = 4,
  kFitUnusable = 5,
};

/// With a message, or with a format and its values.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  template <class... Values>
  requires(sizeof...(Values) > 0) explicit Error(fmt::format_string<Values...> format, Values&&... values)
      : std::runtime_error(fmt::format(format, std::forward<Values>(values)...)) {}
};

/// The command line makes no sense. Exit 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// An input is unreadable or invalid, or an output not writable. Exit 3. what() names file, place and remedy.
class InvalidInput : public Error {
 public:
  using Error::Error;
};

}  // namespace tribotrack::apps
