// Tables of numbers in text files, of whichever program, with the place of whatever is wrong in them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "apps/text/json.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

/// Text as a cell of a CSV file (RFC 4180): in quotes only where it needs them, or would begin a comment.
std::string csv_cell(const std::string& text);

/// A value in a table: a text, "yes" or "no", a number with all its digits; empty for NaN.
std::string cell_text(const Json& value);

/// A table column by column. NaN: no value.
using Column = std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<const char*>>;
using Columns = std::vector<std::pair<std::string, Column>>;

/// As CSV: rows, objects of the same keys, which are the header; or columns, their numbers written by
/// `number`.
std::string csv_of(const std::vector<Json>& rows);
std::string csv_of(const Columns& columns, std::string (*number)(double) = exact);

// The heading of a table's column as people write it: "alpha_sd_deg", "v (mm/s)", "sigma x [px]".

struct Heading {
  std::string quantity;  ///< its words in lower case, joined by `_`, without sd and unit: "alpha"
  std::string unit;      ///< "deg", "mm/s"; empty where there is none
  bool sd = false;       ///< the standard deviation of the quantity
};

/// Words are what stands between blanks, `_`, `/`, `.` and brackets. sd, std, stdev, sigma and uncertainty,
/// wherever they stand, mark the sd; the unit is a known one at the end and never the first word, so that `v`
/// is a quantity ("x in mm" too). Greek letters are read by their names, subscripts as words: x_1.
Heading heading_of(std::string_view text);

enum class Dimension { angle, length, pixels, time, velocity, angular_frequency, frequency, voltage };

/// Factor to SI (angles: rad; pixels: 1) of a heading's unit; nullopt for one of another dimension.
std::optional<double> si_per(std::string_view unit, Dimension dimension);

/// Cells of a line.
using Cells = std::vector<std::string_view>;

/// A table as other people's programs write it, UTF-8, UTF-16 or Latin-1. Which character separates the cells
/// (`;`, tab, `,` or blanks) and which is the decimal sign is what its rows of numbers make the most sense
/// with; a line that begins with `#`, `%`, `!` or `//` is a comment, wherever it stands, and lines of any
/// number may stand above the header. Cells come without surrounding blanks and quotes; within a pair of
/// quotes no separator counts.
class CsvTable {
 public:
  /// How many cells of a line a reader knows as names of its columns; 0: this is no header. The header is the
  /// line of most, one that is no comment before one that is.
  using Known = std::function<int(const Cells& cells)>;

  /// Throws InvalidInput for a spreadsheet or another binary file.
  CsvTable(std::filesystem::path path, std::string text, const Known& known);
  CsvTable(const CsvTable&) = delete;
  CsvTable& operator=(const CsvTable&) = delete;

  /// Names of the columns; empty where no line is a header: then all lines are rows.
  const Cells& header() const { return header_; }
  /// Of a column: its name, and its unit from there or from a line of units below.
  Heading heading(std::size_t column) const;
  /// The lines above the rows, header and comments included, in their order.
  const std::vector<Cells>& above() const { return above_; }
  /// What stands in the line above the header, column by column, where that is no comment.
  const Cells& above_header() const { return above_header_; }
  /// Is this word in a comment above the rows?
  bool is_remarked(std::string_view word) const;

  /// Goes to the next row; false at the end.
  bool next();
  const std::filesystem::path& path() const { return path_; }
  const Cells& cells() const { return cells_; }
  /// Cells up to the last that is not empty.
  std::size_t filled() const;
  /// The comment that stands last above this row.
  std::string_view section() const { return section_; }
  /// Is this row apart from the one above, by an empty line or a comment?
  bool is_apart() const { return apart_; }
  /// "file:line", the place of this row, or of the header before the first.
  std::string place() const;
  /// What is in it, for a reader that does not know it: "it holds ...".
  std::string holds() const;

  /// The number of a cell or of another piece of this line, in this table's decimal sign.
  std::optional<double> number_in(std::string_view cell) const;
  /// Throws InvalidInput unless the cell, or any other piece of this line, is a finite number.
  double number(std::string_view cell) const;
  /// The cell with a decimal point.
  std::string with_point(std::string_view cell) const;
  /// Does a cell say that there is no value: empty, "NaN", "NA", "-", "#N/A"?
  static bool is_none(std::string_view cell);

  /// Throws InvalidInput: "file:line: what", or "file:line:column: what" where a cell is at fault.
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail(std::string_view cell, const std::string& what) const;

 private:
  struct Form {
    char separator = ',', decimal = '.';
  };
  struct Line {
    std::string_view text;
    int number = 0;
    bool comment = false;
  };
  std::optional<Line> line_at(std::size_t& place, int& number) const;
  int sense(std::string_view line, const Form& form, Cells& cells) const;
  void find_form();
  void find_header(const Known& known);
  void skip_head(const Known& known);
  void fit_header();
  bool begins_with_number(const Cells& cells) const;
  bool take_units(const Cells& cells);
  Cells names_in(const Line& line) const;

  std::filesystem::path path_;
  std::string text_;
  Form form_;
  std::size_t columns_ = 0, first_number_ = 0;  ///< of most rows: cells, and the first that is a number
  Cells header_, above_header_;
  std::vector<Cells> above_;
  std::vector<std::string> units_;
  std::string remarks_;                  ///< the comments above the rows
  int header_line_ = 0, first_row_ = 0;  ///< as the lines are numbered

  std::string_view line_text_, header_text_, section_;
  Cells cells_;
  std::size_t place_ = 0;
  int line_ = 0;
  bool apart_ = false;
};

}  // namespace tribotrack::apps
