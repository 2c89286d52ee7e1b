// Numbers, angles and text as the report page writes them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fit/problem.h"

namespace tribotrack::apps {

/// Text made safe for HTML, in elements and in quoted attributes.
std::string escape_html(std::string_view text);

/// A table's cell; number_cell keeps to the right and on one line. The content is HTML already.
std::string cell(const std::string& html);
std::string number_cell(const std::string& html);

/// A table that scrolls where it is too wide. Headings are HTML; those of numbers begin with '>'.
std::string table(const std::string& id, const std::string& classes, const std::vector<std::string>& headings,
                  const std::string& rows);

/// "0.3142", with so many significant digits; an en dash where there is no value (NaN), an infinity sign
/// where open.
std::string number(double value, int digits = 4);

/// A value rounded to its sd (number_text.h), with a true minus sign; number(value) without a usable sd.
std::string rounded(double value, double sd);

/// "0.10012(31)" (number_text.h), with a true minus sign; "not determined".
std::string quoted_value(double value, double sd);

/// A cell that shows the same and keeps all digits of both for the table's CSV; the value alone, in four
/// digits, where no sd is known (NaN).
std::string quoted_cell(double value, double sd);

/// "0.09952 to 0.10073", rounded to the sd or finer, such that its half width keeps two digits; an en dash
/// where there is no interval.
std::string interval_text(double low, double high, double sd);

/// A sentence of the program as HTML, with the page's symbols: "mu1 = 0.1 +- 0.01" becomes "μ₁ = 0.1 ± 0.01".
/// Names of files and runs keep their letters.
std::string sentence_html(std::string_view sentence);

/// Sentences as a list.
std::string html_list(const std::vector<std::string>& sentences);

/// "5π/6" for multiples of pi/12 (within 1e-4 rad), else "1.234 rad".
std::string angle(double rad);

/// A parameter as papers write it.
struct ParameterText {
  std::string symbol;   ///< "μ₁"
  std::string unit;     ///< "" for a pure number
  std::string meaning;  ///< one line
};

/// By its campaign key ("mu1", "phase_lag_rad", ...); an unknown key stands for itself.
ParameterText parameter_text(const std::string& key);
inline ParameterText parameter_text(fit::FitParameter parameter) {
  return parameter_text(std::string(fit::to_string(parameter)));
}

/// Base 64 (RFC 4648), for pictures inside the page.
std::string base64(const std::vector<unsigned char>& bytes);

}  // namespace tribotrack::apps
