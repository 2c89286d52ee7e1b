// What can go wrong, as the shell sees it.
#pragma once

#include <stdexcept>

namespace tribotrack::apps {

enum ExitCode {
  kDone = 0,
  kUnexpected = 1,
  kUsage = 2,
  kInvalidInput = 3,
  kQualityGate = 4,
  kFitUnusable = 5,
};

/// The command line makes no sense. Exit 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An input is unreadable or invalid, or an output not writable. Exit 3. what() names file, place and remedy.
class InvalidInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tribotrack::apps
