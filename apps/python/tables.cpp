#include "apps/python/tables.h"

#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <utility>
#include <vector>

#include "apps/program/errors.h"
#include "apps/python/values.h"
#include "apps/text/number_text.h"

namespace tribotrack::python {

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
