#include "apps/python/errors.h"

#include <cctype>
#include <stdexcept>

#include "apps/recording/track_recording.h"
#include "fit/measurement.h"
#include "model/trajectory.h"

namespace tribotrack::python {

namespace py = pybind11;

namespace {

py::object type_named(const char* name) {
  return py::module_::import("tribotrack._errors").attr(name);
}

py::object made(const char* type, const std::exception& error) {
  return type_named(type)(in_keywords(error.what()));
}

void raise(const py::object& exception) {
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
}

py::object ambiguous(const apps::AmbiguousPart& error) {
  py::object exception = made("AmbiguousPartError", error);
  py::list discs;
  for (const vision::Circle& disc : error.discs) discs.append(py::make_tuple(disc.x, disc.y, disc.radius));
  exception.attr("frame") = error.frame;
  exception.attr("discs_px") = discs;
  return exception;
}

void translate(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const MissingFile& missing) {
    raise(made("MissingFileError", missing));
  } catch (const apps::AmbiguousPart& question) {
    raise(ambiguous(question));
  } catch (const apps::UsageError& refused) {
    raise(made("InputError", refused));
  } catch (const apps::InvalidInput& refused) {
    raise(made("InputError", refused));
  } catch (const vision::InputError& refused) {
    raise(made("InputError", refused));
  } catch (const fit::DataError& refused) {
    raise(made("InputError", refused));
  } catch (const std::invalid_argument& refused) {  // model::InvalidParameter, too
    raise(made("InputError", refused));
  } catch (const model::StepLimitExceeded& refused) {
    raise(made("InputError", refused));
  }
}

bool starts_word(const std::string& text, std::size_t at) {
  return at == 0 || text[at - 1] == ' ' || text[at - 1] == '(' || text[at - 1] == '`';
}

}  // namespace

std::string in_keywords(const std::string& sentence) {
  std::string said;
  for (std::size_t at = 0; at < sentence.size();) {
    const bool flag = sentence.compare(at, 2, "--") == 0 && starts_word(sentence, at) &&
                      at + 2 < sentence.size() && std::islower(static_cast<unsigned char>(sentence[at + 2]));
    if (!flag) {
      said += sentence[at++];
      continue;
    }
    for (at += 2; at < sentence.size(); ++at) {
      const auto c = static_cast<unsigned char>(sentence[at]);
      if (std::islower(c) || std::isdigit(c))
        said += sentence[at];
      else if (c == '-')
        said += '_';
      else
        break;
    }
    const bool value = at + 1 < sentence.size() && sentence[at] == ' ' &&
                       std::isdigit(static_cast<unsigned char>(sentence[at + 1]));
    if (value) said += '=', ++at;
  }
  return said;
}

void require_there(const std::filesystem::path& file, const std::exception& error) {
  std::error_code unknown;
  if (!std::filesystem::exists(file, unknown)) throw MissingFile(error.what());
}

void translate_errors() {
  py::register_exception_translator(&translate);
}

void warn_of_quality(const std::string& sentence) {
  if (PyErr_WarnEx(type_named("QualityWarning").ptr(), in_keywords(sentence).c_str(), 2) != 0)
    throw py::error_already_set();
}

}  // namespace tribotrack::python
