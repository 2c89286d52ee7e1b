// What the program refuses, as Python's exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "apps/program/errors.h"
#include "vision/picture.h"

namespace tribotrack::python {

/// A file or folder that is not there.
class MissingFile : public apps::InvalidInput {
 public:
  using apps::InvalidInput::InvalidInput;
};

/// From here on the program's errors become those of tribotrack/_errors.py, with the program's sentence.
void translate_errors();

/// The program names flags, "--disc-diameter-mm 6"; here they are keywords: "disc_diameter_mm=6".
std::string in_keywords(const std::string& sentence);

/// warnings.warn(sentence, QualityWarning).
void warn_of_quality(const std::string& sentence);

/// Throws MissingFile with the error's sentence where there is no such file.
void require_there(const std::filesystem::path& file, const std::exception& error);

/// read(): where it refuses because `file` is not there, MissingFile says so.
template <class Read>
auto reading(const std::filesystem::path& file, const Read& read) {
  try {
    return read();
  } catch (const apps::InvalidInput& error) {
    require_there(file, error);
    throw;
  } catch (const vision::InputError& error) {
    require_there(file, error);
    throw;
  }
}

// Work without Python's lock: other Python threads run meanwhile, Ctrl-C is heard, progress is told.
//
// The work has a thread of its own. The calling thread waits for it without the lock, wakes twenty times a
// second, takes the lock, lets Python see to its signals and calls `progress`. Where either raises, the work
// is asked to stop, which it does when it next tells of its progress, and the exception goes up at once.

/// How work tells of its progress, from any of its threads; throws where it has been asked to stop.
using Tell = std::function<void(const std::string& stage, std::int64_t done, std::int64_t total)>;

/// Does the work. `progress` is a Python callable or None. The work must hold all it needs by value: it may
/// outlast this call for a moment after an exception. `kept`, which may hold Python's objects, lives as long
/// as the work. Throws what the work throws. Called with Python's lock.
void release(const std::function<void(const Tell&)>& work, const pybind11::object& progress,
             const std::shared_ptr<void>& kept);

/// The same for work with a result.
template <class Result>
Result released(std::function<Result(const Tell&)> work, const pybind11::object& progress = pybind11::none(),
                const std::shared_ptr<void>& kept = nullptr) {
  const auto result = std::make_shared<std::optional<Result>>();
  release([result, work = std::move(work)](const Tell& tell) { result->emplace(work(tell)); }, progress,
          kept);
  return std::move(**result);
}

/// Waits for work that was asked to stop. The module has Python call it before it ends.
void wait_for_stopped_work();

}  // namespace tribotrack::python
