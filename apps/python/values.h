// Python's values as the program's, and back.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <optional>
#include <string>
#include <vector>

#include "apps/files/track_rows.h"
#include "apps/text/json.h"
#include "vision/picture.h"

namespace tribotrack::python {

/// dict, list, str, int, float, bool and None; what is not finite becomes None, as in the program's files.
pybind11::object to_python(const apps::Json& json);

/// The other way. Numbers and lists of NumPy and paths are taken, None in a dict is left out. Throws
/// InvalidInput naming the place.
apps::Json to_json(const pybind11::handle& value, const std::string& place);

/// A finite number; where the name ends in _rad also a text such as "pi/3" or "90deg". Throws UsageError
/// naming the flag of that name.
double number_of(const std::string& name, const pybind11::handle& value);

/// A member of a dict of options. Empty where it is None or not there.
pybind11::object member(const pybind11::dict& options, const char* name);
std::optional<double> number_in(const pybind11::dict& options, const char* name);
/// A text, or a path (os.PathLike); empty where there is none.
std::string text_in(const pybind11::dict& options, const char* name);
bool truth_in(const pybind11::dict& options, const char* name);
std::optional<long> whole_in(const pybind11::dict& options, const char* name);
/// (x, y, radius) in px.
std::optional<vision::Circle> circle_in(const pybind11::dict& options, const char* name);
/// `count` finite numbers. Throws UsageError: the flag must be `form`.
std::vector<double> numbers_of(const std::string& name, const pybind11::handle& value, std::size_t count,
                               const char* form);
/// A file's name as Python gives it: a str or a pathlib.Path.
bool is_path(const pybind11::handle& value);
std::string path_of(const pybind11::handle& value);

/// A NumPy array of one dimension.
pybind11::array_t<double> array_of(const std::vector<double>& values);

// Tracks as dicts of NumPy arrays, one for each column of their table, and back.

/// NaN for an empty cell; `status` holds texts.
pybind11::dict columns_of(const apps::TrackRows& rows);

/// The text of the CSV with these columns: arrays, lists or a pandas DataFrame's, the key `meta` left out.
/// Throws InvalidInput, `name` beginning its message.
std::string csv_of(const pybind11::object& table, const std::string& name);

}  // namespace tribotrack::python
