// The module tribotrack._core: the program's commands as one function. Words of a command line come in;
// columns, a JSON object and sentences of doubt go out. Work runs without Python's lock.
#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <atomic>
#include <bit>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "apps/commands/command.h"
#include "apps/program/called.h"
#include "apps/program/errors.h"
#include "apps/recording/track.h"
#include "fit/measurement.h"
#include "model/trajectory.h"

namespace tribotrack::python {

namespace py = pybind11;
using apps::UsageError;

namespace {

struct Stop {};

/// Calls `tell` twenty times a second at most; where that raises, the work ends by an exception that is no
/// std::exception: nobody takes it for an error of one run of many. `tell` must outlive it.
auto teller(const py::function& tell) {
  using Clock = std::chrono::steady_clock;
  const auto next = std::make_shared<std::atomic<Clock::time_point>>();
  return [next, called = tell.ptr()](const std::string& stage, std::int64_t done, std::int64_t total) {
    const Clock::time_point now = Clock::now();
    Clock::time_point due = *next;
    if (now < due || !next->compare_exchange_strong(due, now + std::chrono::milliseconds(50))) return;
    const py::gil_scoped_acquire locked;
    try {
      py::handle{called}(stage, done, total);
    } catch (const py::error_already_set&) {
      throw Stop{};
    }
  };
}

/// The levels of an array where they lie. Throws UsageError for what is no stack of grey pictures.
vision::FrameStack stack_of(const py::buffer_info& buffer) {
  const std::string expected =
      "frames must be an array of uint8 or uint16 grey levels of the shape (frames, height, width)";
  if (buffer.ndim != 3)
    throw UsageError(fmt::format("{}, not of {} dimensions{}", expected, buffer.ndim,
                                 buffer.ndim == 4 ? ": make grey of colour first" : ""));
  std::string format = buffer.format;
  if (format.size() == 2 && (format[0] == '@' || format[0] == '=' || format[0] == '|' ||
                             format[0] == (std::endian::native == std::endian::little ? '<' : '>')))
    format.erase(0, 1);
  if (format != "B" && format != "H")
    throw UsageError(
        fmt::format("{}, not of the type \"{}\": convert them with .astype", expected, buffer.format));
  for (const py::ssize_t count : buffer.shape)
    if (count < 1 || count > 1'000'000'000)
      throw UsageError(
          fmt::format("{}, not ({}, {}, {})", expected, buffer.shape[0], buffer.shape[1], buffer.shape[2]));
  return {buffer.ptr,
          format == "B" ? 1 : 2,
          buffer.shape[0],
          static_cast<int>(buffer.shape[2]),
          static_cast<int>(buffer.shape[1]),
          buffer.strides[0],
          buffer.strides[1],
          buffer.strides[2]};
}

/// `bits`: that are significant; nothing: all.
std::function<std::shared_ptr<vision::FrameSource>(double)> source_of(const vision::FrameStack& stack,
                                                                      const std::optional<int>& bits) {
  const int most = 8 * stack.bytes_per_level;
  if (bits && (*bits < 1 || *bits > most))
    throw UsageError(fmt::format("--bits must be 1 to {} for levels of {} bytes, not {}", most,
                                 stack.bytes_per_level, *bits));
  return [stack, used = bits.value_or(most)](double rate) {
    return std::make_shared<vision::StackSource>(stack, rate, used);
  };
}

py::object object_of(const std::vector<const char*>& words) {
  return py::cast(words);
}
template <class Number>
py::object object_of(const std::vector<Number>& values) {
  return py::array_t<Number>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// `frames`: None, or an array in place of a recording; `input`: the JSON of Called::input.
std::tuple<py::dict, std::string, std::vector<std::string>> run(const std::vector<std::string>& words,
                                                                const py::function& tell,
                                                                const py::object& frames,
                                                                const std::optional<int>& bits,
                                                                const std::string& input) {
  apps::Called called;
  py::buffer_info buffer;
  if (!frames.is_none()) {
    if (PyObject_CheckBuffer(frames.ptr()) == 0)
      throw UsageError(fmt::format("the source must be a path or an array of frames, not {}",
                                   Py_TYPE(frames.ptr())->tp_name));
    buffer = py::reinterpret_borrow<py::buffer>(frames).request();
    called.frames = source_of(stack_of(buffer), bits);
  } else if (bits) {
    throw UsageError("--bits belongs to frames in memory");
  }
  called.input = apps::Json::parse(input);
  apps::Context context;
  context.called = &called;
  context.progress = teller(tell);
  {
    const py::gil_scoped_release unlocked;
    CLI::App app("", "tribotrack");
    for (const auto& add :
         {apps::add_simulate, apps::add_sweep, apps::add_track, apps::add_measure, apps::add_fit})
      add(app, context);
    context.quiet = true;
    apps::parse(app, words);
  }
  py::dict columns;
  for (const auto& [name, column] : called.columns)
    columns[py::str(name)] = std::visit([](const auto& values) { return object_of(values); }, column);
  // As the program's files have it: what is not finite is null.
  return {columns, called.object.dump(-1, ' ', false, apps::Json::error_handler_t::replace), called.doubts};
}

// What the program refuses, as the exceptions of tribotrack/_errors.py.

void raise(const char* type, const std::exception& refused, const apps::AmbiguousPart* question = nullptr) {
  const py::object exception = py::module_::import("tribotrack._errors").attr(type)(refused.what());
  if (question) {
    py::list discs;
    for (const vision::Circle& disc : question->discs)
      discs.append(py::make_tuple(disc.x, disc.y, disc.radius));
    exception.attr("frame") = question->frame;
    exception.attr("discs_px") = discs;
  }
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
}

void translate(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const apps::AmbiguousPart& question) {
    raise("AmbiguousPartError", question, &question);
  } catch (const apps::UsageError& refused) {
    raise("InputError", refused);
  } catch (const apps::InvalidInput& refused) {
    raise("InputError", refused);
  } catch (const vision::InputError& refused) {
    raise("InputError", refused);
  } catch (const fit::DataError& refused) {
    raise("InputError", refused);
  } catch (const std::invalid_argument& refused) {  // model::InvalidParameter, too
    raise("InputError", refused);
  } catch (const model::StepLimitExceeded& refused) {
    raise("InputError", refused);
  } catch (const Stop&) {
    PyErr_SetNone(PyExc_InterruptedError);
  }
}

}  // namespace

}  // namespace tribotrack::python

PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  module.doc() = "The program's commands as one function; use tribotrack, which documents them.";
  module.attr("__version__") = TRIBOTRACK_VERSION;
  py::register_exception_translator(&tribotrack::python::translate);
  module.def("run", &tribotrack::python::run, py::arg("words"), py::arg("tell"), py::arg("frames"),
             py::arg("bits"), py::arg("input"));
}
