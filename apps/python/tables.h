// Tracks as dicts of NumPy arrays, one for each column of their table, and back.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "apps/files/track_rows.h"

namespace tribotrack::python {

/// NaN for an empty cell; `status` holds texts.
pybind11::dict columns_of(const apps::TrackRows& rows);

/// The text of the CSV with these columns: arrays, lists or a pandas DataFrame's, the key `meta` left out.
/// Throws InvalidInput, `name` beginning its message.
std::string csv_of(const pybind11::object& table, const std::string& name);

}  // namespace tribotrack::python
