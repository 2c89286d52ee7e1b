// What the program refuses, as Python's exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <exception>
#include <filesystem>
#include <string>

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

}  // namespace tribotrack::python
