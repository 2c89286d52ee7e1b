// The module's functions, as tribotrack/__init__.py calls them: keywords come as a dict.
#pragma once

#include <pybind11/pybind11.h>

namespace tribotrack::python {

/// `values`: of scenario_parameter_names(), start, samples_per_cycle.
pybind11::dict simulate(const pybind11::object& scenario, const pybind11::dict& values);

/// `over`: {name: values} or None; `values` as above.
pybind11::dict sweep(const pybind11::object& scenario, const pybind11::object& over,
                     const pybind11::dict& values, const pybind11::object& threads,
                     const pybind11::object& progress);

/// `source`: a path, or an array of grey levels (frames, height, width).
pybind11::dict track(const pybind11::object& source, const pybind11::dict& options,
                     const pybind11::object& progress);

/// `track`: a path, or the table's columns with `meta`.
pybind11::dict measure(const pybind11::object& track, const pybind11::dict& options);

/// `campaign`: a path, or a campaign file's structure.
pybind11::dict fit(const pybind11::object& campaign, const pybind11::dict& options,
                   const pybind11::object& progress);

}  // namespace tribotrack::python
