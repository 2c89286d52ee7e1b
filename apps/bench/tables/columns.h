// A table of benchmark rows: each column is described once and printed as CSV, as text and on the page.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "apps/bench/tables/html_table.h"
#include "apps/text/number_text.h"

namespace tribotrack::bench {

// How a value is printed. Plain ones: std::string (quoted in CSV), const char* (bare), bool (yes or no),
// integers, double (ten digits in CSV). Without a value: an empty cell in CSV, "-" in text.
struct Exact {
  double value;  ///< all digits in CSV
};
struct Seconds {
  double value;  ///< in text microseconds or milliseconds
};
struct Percent {
  double share;  ///< the share in CSV, 100 times as much in text
};

/// For columns that are members of a row: exactly(&Row::radius).
template <class Member>
auto exactly(Member member) {
  return [member](const auto& row) { return Exact{std::invoke(member, row)}; };
}
template <class Member>
auto seconds(Member member) {
  return [member](const auto& row) { return Seconds{std::invoke(member, row)}; };
}
template <class Member>
auto percent(Member member) {
  return [member](const auto& row) { return Percent{std::invoke(member, row)}; };
}
template <class Member>
auto bare(Member member) {
  return [member](const auto& row) { return std::invoke(member, row).c_str(); };
}

inline const char* yes(bool value) {
  return value ? "yes" : "no";
}

inline std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

template <class Value>
std::string csv_cell(const Value& value) {
  if constexpr (std::is_same_v<Value, std::string>)
    return quoted(value);
  else if constexpr (std::is_same_v<Value, bool>)
    return yes(value);
  else if constexpr (std::is_same_v<Value, double>)
    return apps::compact(value);
  else if constexpr (std::is_same_v<Value, Exact>)
    return apps::exact(value.value);
  else if constexpr (std::is_same_v<Value, Seconds>)
    return apps::compact(value.value);
  else if constexpr (std::is_same_v<Value, Percent>)
    return apps::compact(value.share);
  else
    return fmt::format("{}", value);
}
template <class Value>
std::string csv_cell(const std::optional<Value>& value) {
  return value ? csv_cell(*value) : std::string();
}

template <class Value>
std::string text_cell(const char* format, const Value& value) {
  if constexpr (std::is_same_v<Value, bool>)
    return yes(value);
  else if constexpr (std::is_same_v<Value, Exact>)
    return fmt::format(fmt::runtime(format), value.value);
  else if constexpr (std::is_same_v<Value, Seconds>)
    return value.value < 1e-3 ? fmt::format("{:.4g} us", 1e6 * value.value)
                              : fmt::format("{:.4g} ms", 1e3 * value.value);
  else if constexpr (std::is_same_v<Value, Percent>)
    return fmt::format(fmt::runtime(format), 100 * value.share);
  else
    return fmt::format(fmt::runtime(format), value);
}
template <class Value>
std::string text_cell(const char* format, const std::optional<Value>& value) {
  return value ? text_cell(format, *value) : "-";
}

/// One column. `get`: a member of the row or a function of it. `align` with width, such as ">9", of heading
/// and cells; empty: the column is in the CSV only. `name` empty: in the text only.
template <class Row>
struct Column {
  template <class Get>
  Column(const char* csv_name, Get get, const char* text_heading = "", const char* alignment = "",
         const char* format = "{}")
      : name(csv_name),
        heading(text_heading),
        align(alignment),
        csv([get](const Row& row) {
          const auto value = std::invoke(get, row);
          return csv_cell(value);
        }),
        text([get, format](const Row& row) {
          const auto value = std::invoke(get, row);
          return text_cell(format, value);
        }) {}

  /// For the page. The CSV's digits stand behind a number that the text rounds.
  bool number() const { return align.starts_with('>'); }
  HtmlCell html_heading() const {
    std::string words(align.empty() ? name : heading);
    std::ranges::replace(words, '_', ' ');
    return {std::move(words), {}, number()};
  }
  HtmlCell html_cell(const Row& row) const {
    return {text(row), number() && !name.empty() ? csv(row) : std::string(), number()};
  }

  std::string_view name, heading, align;
  std::function<std::string(const Row&)> csv, text;
};

template <class Row>
class Columns {
 public:
  Columns(std::initializer_list<Column<Row>> columns) : columns_(columns) {}

  std::string csv(const std::vector<Row>& rows) const {
    std::string out = csv_line([](const Column<Row>& column) { return column.name; });
    for (const Row& row : rows)
      out.append(csv_line([&](const Column<Row>& column) { return column.csv(row); }));
    return out;
  }
  /// `first` takes the place of the first column's heading.
  std::string heading(std::string_view first = "") const {
    return text_line(
        [&](const Column<Row>& column) { return first.empty() ? column.heading : std::exchange(first, ""); });
  }
  std::string line(const Row& row) const {
    return text_line([&](const Column<Row>& column) { return column.text(row); });
  }
  std::string lines(const std::vector<Row>& rows, const std::string& indent = "") const {
    std::string out = fmt::format("{}{}", indent, heading());
    for (const Row& row : rows) out.append(indent).append(line(row));
    return out;
  }
  /// The columns of the text as a table of the page; before them those that only the CSV has and `also`
  /// names.
  std::string html(std::string_view id, const std::vector<Row>& rows,
                   std::initializer_list<std::string_view> also = {}) const {
    std::vector<const Column<Row>*> shown;
    for (const std::string_view name : also)
      shown.push_back(&*std::ranges::find(columns_, name, &Column<Row>::name));
    for (const Column<Row>& column : columns_)
      if (!column.align.empty()) shown.push_back(&column);
    std::vector<HtmlCell> headings;
    headings.reserve(shown.size());
    for (const Column<Row>* column : shown) headings.push_back(column->html_heading());
    std::vector<std::vector<HtmlCell>> cells;
    for (const Row& row : rows) {
      cells.emplace_back();
      for (const Column<Row>* column : shown) cells.back().push_back(column->html_cell(row));
    }
    return html_table(id, headings, cells);
  }

 private:
  template <class Cell>
  std::string csv_line(const Cell& cell) const {
    std::string out;
    for (const Column<Row>& column : columns_) {
      if (column.name.empty()) continue;
      if (&column != &columns_.front()) out.push_back(',');
      out.append(cell(column));
    }
    out.push_back('\n');
    return out;
  }
  template <class Cell>
  std::string text_line(const Cell& cell) const {
    std::string out;
    for (const Column<Row>& column : columns_) {
      if (column.align.empty()) continue;
      const std::string form = fmt::format("{{:{}}}", column.align);
      const std::string padded = fmt::format(fmt::runtime(form), cell(column));
      if (!out.empty() && !padded.empty()) out.push_back(' ');
      out.append(padded);
    }
    out.push_back('\n');
    return out;
  }

  std::vector<Column<Row>> columns_;
};

}  // namespace tribotrack::bench
