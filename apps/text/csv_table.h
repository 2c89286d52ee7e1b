// CSV files, line by line, with the place of whatever is wrong in them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tribotrack::apps {

/// Text as a cell of a CSV file (RFC 4180): in quotes only where it needs them.
std::string csv_cell(const std::string& text);

/// The lines of a table in a text file as cells without their surrounding blanks and quotes. The first line
/// that holds one of `;`, tab and comma tells what separates, in this order; with `;` and tab decimal commas
/// are read as well. Where none of the first lines does, blanks separate. Within a pair of quotes no
/// separator counts. A byte-order mark is skipped.
class CsvTable {
 public:
  CsvTable(std::filesystem::path path, std::string text);
  CsvTable(const CsvTable&) = delete;
  CsvTable& operator=(const CsvTable&) = delete;

  /// Goes to the next line that is not empty; false at the end.
  bool next();
  const std::vector<std::string_view>& cells() const { return cells_; }
  /// Cells up to the last that is not empty.
  std::size_t filled() const;
  bool separated_by_semicolons() const { return separator_ == ';'; }
  int line() const { return line_; }
  const std::filesystem::path& path() const { return path_; }
  /// "file:line", the place of this line.
  std::string place() const;
  /// The cell with a decimal point, where this table may have decimal commas.
  std::string with_point(std::string_view cell) const;

  /// Throws InvalidInput unless the cell, or any other piece of this line, is a finite number.
  double number(std::string_view cell) const;

  /// Throws InvalidInput: "file:line: what", or "file:line:column: what" where a cell is at fault.
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail(std::string_view cell, const std::string& what) const;

 private:
  void split(std::string_view line);

  std::filesystem::path path_;
  std::string text_;
  char separator_ = ',';
  std::string_view line_text_;
  std::vector<std::string_view> cells_;
  std::size_t place_ = 0;
  int line_ = 0;
};

// The heading of a table's column as people write it: "alpha_sd_deg", "v (mm/s)", "sigma x [px]".

struct Heading {
  std::string quantity;  ///< its words in lower case, joined by `_`, without sd and unit: "alpha"
  std::string unit;      ///< "deg", "mm/s"; empty where there is none
  bool sd = false;       ///< the standard deviation of the quantity
};

/// Words are what stands between blanks, `_`, `/`, `.` and brackets. sd, std, stdev, sigma and uncertainty,
/// wherever they stand, mark the sd; the unit is a known one at the end and never the first word, so that `v`
/// is a quantity. Greek letters are read by their names.
Heading heading_of(std::string_view text);

enum class Dimension { angle, length, pixels, time, velocity, angular_frequency, frequency, voltage };

/// Factor to SI (angles: rad; pixels: 1) of a heading's unit; nullopt for one of another dimension.
std::optional<double> si_per(std::string_view unit, Dimension dimension);

}  // namespace tribotrack::apps
