#include "apps/python/values.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/number_text.h"

namespace tribotrack::python {

namespace py = pybind11;
using apps::Json;
using apps::UsageError;

namespace {

std::string flag_of(std::string name) {
  std::ranges::replace(name, '_', '-');
  return "--" + name;
}

std::string shown(const py::handle& value) {
  return py::repr(value).cast<std::string>();
}

bool has(const py::handle& value, const char* attribute) {
  return py::hasattr(value, attribute);
}

/// Python's float(value), but for texts and truths. Nothing where there is none.
std::optional<double> float_of(const py::handle& value) {
  if (py::isinstance<py::str>(value) || py::isinstance<py::bool_>(value)) return std::nullopt;
  const double number = PyFloat_AsDouble(value.ptr());
  if (number == -1.0 && PyErr_Occurred()) {
    PyErr_Clear();
    return std::nullopt;
  }
  return number;
}

Json list_of(const py::handle& value, const std::string& place) {
  Json list = Json::array();
  for (const py::handle& item : py::reinterpret_borrow<py::iterable>(value))
    list.push_back(to_json(item, place));
  return list;
}

Json object_of(const py::dict& value, const std::string& place) {
  Json object = Json::object();
  for (const auto& [key, item] : value) {
    if (!py::isinstance<py::str>(key))
      throw apps::InvalidInput(fmt::format("{}: the key {} must be a text", place, shown(key)));
    const auto name = key.cast<std::string>();
    if (!item.is_none()) object[name] = to_json(item, fmt::format("{}: `{}`", place, name));
  }
  return object;
}

}  // namespace

py::object to_python(const Json& json) {
  switch (json.type()) {
    case Json::value_t::boolean:
      return py::bool_(json.get<bool>());
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
      return py::int_(json.get<std::int64_t>());
    case Json::value_t::number_float: {
      const auto value = json.get<double>();
      return std::isfinite(value) ? py::object(py::float_(value)) : py::object(py::none());
    }
    case Json::value_t::string:
      return py::str(json.get<std::string>());
    case Json::value_t::array: {
      py::list list;
      for (const Json& item : json) list.append(to_python(item));
      return list;
    }
    case Json::value_t::object: {
      py::dict dict;
      for (const auto& [key, value] : json.items()) dict[py::str(key)] = to_python(value);
      return dict;
    }
    default:
      return py::none();
  }
}

Json to_json(const py::handle& value, const std::string& place) {
  if (Py_EnterRecursiveCall(" in a value given to tribotrack") != 0) throw py::error_already_set();
  struct Leave {
    ~Leave() { Py_LeaveRecursiveCall(); }
  } const leave;
  if (value.is_none()) return {};
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::dict>(value)) return object_of(py::reinterpret_borrow<py::dict>(value), place);
  if (has(value, "__fspath__")) return path_of(value);
  if (has(value, "tolist")) return to_json(value.attr("tolist")(), place);  // of NumPy: number or list
  if (PyIndex_Check(value.ptr()) != 0) {
    const py::int_ whole = py::reinterpret_steal<py::int_>(PyNumber_Index(value.ptr()));
    if (!whole) throw py::error_already_set();
    return whole.cast<std::int64_t>();
  }
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) return list_of(value, place);
  if (const auto number = float_of(value)) return *number;
  throw apps::InvalidInput(fmt::format("{} must be a number, a text, a list or a dict, not {}", place,
                                       Py_TYPE(value.ptr())->tp_name));
}

double number_of(const std::string& name, const py::handle& value) {
  const bool angle = name.ends_with("_rad");
  std::optional<double> number = float_of(value);
  if (angle && py::isinstance<py::str>(value)) number = apps::parse_angle(value.cast<std::string>());
  if (!number || !std::isfinite(*number))
    throw UsageError(fmt::format(
        "{} must be {}, not {}", flag_of(name),
        angle ? "an angle such as 0.5 (radians), pi/2, 11pi/9 or 90deg" : "a finite number", shown(value)));
  if (!angle) return *number;
  if (const std::string slip = apps::angle_slip(*number); !slip.empty())
    throw UsageError(fmt::format("{}: {}", flag_of(name), slip));
  return *number;
}

py::object member(const py::dict& options, const char* name) {
  return options.contains(name) ? py::reinterpret_borrow<py::object>(options[name]) : py::object(py::none());
}

std::optional<double> number_in(const py::dict& options, const char* name) {
  const py::object value = member(options, name);
  if (value.is_none()) return std::nullopt;
  return number_of(name, value);
}

std::string text_in(const py::dict& options, const char* name) {
  const py::object value = member(options, name);
  if (value.is_none()) return {};
  if (!py::isinstance<py::str>(value) && !has(value, "__fspath__"))
    throw UsageError(fmt::format("{} must be a text, not {}", flag_of(name), shown(value)));
  return path_of(value);
}

bool truth_in(const py::dict& options, const char* name) {
  const py::object value = member(options, name);
  return !value.is_none() && value.cast<bool>();
}

std::optional<long> whole_in(const py::dict& options, const char* name) {
  const auto number = number_in(options, name);
  if (!number) return std::nullopt;
  constexpr double largest = 0x1p53;
  if (*number != std::floor(*number) || std::abs(*number) > largest)
    throw UsageError(fmt::format("{} must be a whole number, not {}", flag_of(name), *number));
  return static_cast<long>(*number);
}

std::vector<double> numbers_of(const std::string& name, const py::handle& value, std::size_t count,
                               const char* form) {
  std::vector<double> numbers;
  if (!py::isinstance<py::str>(value) && PySequence_Check(value.ptr()) != 0)
    for (const py::handle& item : py::reinterpret_borrow<py::sequence>(value))
      if (const auto number = float_of(item); number && std::isfinite(*number)) numbers.push_back(*number);
  if (numbers.size() != count || static_cast<std::size_t>(PySequence_Size(value.ptr())) != count) {
    PyErr_Clear();
    throw UsageError(fmt::format("{} must be {}, not {}", flag_of(name), form, shown(value)));
  }
  return numbers;
}

std::optional<vision::Circle> circle_in(const py::dict& options, const char* name) {
  const py::object value = member(options, name);
  if (value.is_none()) return std::nullopt;
  const auto v = numbers_of(name, value, 3, "(x, y, radius) in pixels, such as (640, 400, 150)");
  return vision::Circle{v[0], v[1], v[2]};
}

bool is_path(const py::handle& value) {
  return py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__");
}

std::string path_of(const py::handle& value) {
  return py::module_::import("os").attr("fsdecode")(value).cast<std::string>();
}

py::array_t<double> array_of(const std::vector<double>& values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

namespace py = pybind11;

namespace {

using Column = std::pair<std::string, std::vector<std::string>>;

/// None and NaN are empty cells.
Column column_of(const std::string& name, const py::handle& values, const std::string& table) {
  Column column{name, {}};
  if (name == "status") {
    for (const py::handle& value : py::iter(values))
      column.second.push_back(py::str(value).cast<std::string>());
    return column;
  }
  const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(values);
  if (!numbers || numbers.ndim() != 1)
    throw apps::InvalidInput(fmt::format("{}: the column {} must be a row of numbers", table, name));
  for (py::ssize_t k = 0; k < numbers.size(); ++k) column.second.push_back(apps::exact(numbers.at(k)));
  return column;
}

}  // namespace

py::dict columns_of(const apps::TrackRows& table) {
  py::dict dict;
  py::array_t<std::int64_t> frames(static_cast<py::ssize_t>(table.rows.size()));
  std::vector<double> times;
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    frames.mutable_at(k) = table.rows[k].frame;
    times.push_back(table.rows[k].time_s);
  }
  dict["frame"] = frames;
  dict["time_s"] = array_of(times);
  apps::for_each_column(table, [&](const char* name, double apps::TrackRow::*number) {
    if (number != nullptr) {
      std::vector<double> values;
      for (const apps::TrackRow& row : table.rows) values.push_back(row.*number);
      dict[name] = array_of(values);
      return;
    }
    py::list words;
    for (const apps::TrackRow& row : table.rows) words.append(vision::to_string(row.status));
    dict[name] = py::module_::import("numpy").attr("array")(words, "U4");
  });
  return dict;
}

std::string csv_of(const py::object& table, const std::string& name) {
  std::vector<Column> columns;
  for (const py::handle& key : table.attr("keys")()) {
    if (!py::isinstance<py::str>(key)) continue;
    const auto column = key.cast<std::string>();
    if (column != "meta") columns.push_back(column_of(column, table[key], name));
  }
  std::string text;
  for (const Column& column : columns) {
    if (column.second.size() != columns.front().second.size())
      throw apps::InvalidInput(fmt::format("{}: the column {} has {} rows, {} has {}", name, column.first,
                                           column.second.size(), columns.front().first,
                                           columns.front().second.size()));
    text += (text.empty() ? "" : ",") + column.first;
  }
  text += '\n';
  for (std::size_t row = 0; !columns.empty() && row < columns.front().second.size(); ++row) {
    for (std::size_t k = 0; k < columns.size(); ++k) text += (k > 0 ? "," : "") + columns[k].second[row];
    text += '\n';
  }
  return text;
}

}  // namespace tribotrack::python
