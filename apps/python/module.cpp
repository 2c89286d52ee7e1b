// tribotrack._core: what tribotrack/__init__.py is written on.
#include <pybind11/pybind11.h>

#include "apps/files/scenario_file.h"
#include "apps/python/doors.h"
#include "apps/python/errors.h"
#include "apps/python/released.h"

namespace py = pybind11;

PYBIND11_MODULE(_core, module) {
  namespace python = tribotrack::python;
  module.doc() = "The program's rooms as Python's functions; use tribotrack, which documents them.";
  module.attr("__version__") = TRIBOTRACK_VERSION;
  python::translate_errors();
  module.def("simulate", &python::simulate, py::arg("scenario"), py::arg("values"));
  module.def("sweep", &python::sweep, py::arg("scenario"), py::arg("over"), py::arg("values"),
             py::arg("threads"), py::arg("progress"));
  module.def("track", &python::track, py::arg("source"), py::arg("options"), py::arg("progress"));
  module.def("measure", &python::measure, py::arg("track"), py::arg("options"));
  module.def("fit", &python::fit, py::arg("campaign"), py::arg("options"), py::arg("progress"));
  module.def("scenario_parameter_names", [] {
    py::list names;
    for (const std::string& name : tribotrack::apps::scenario_parameter_names()) names.append(name);
    return names;
  });
  py::module_::import("atexit").attr("register")(py::cpp_function(&python::wait_for_stopped_work));
}
