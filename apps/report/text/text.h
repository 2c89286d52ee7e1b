// Numbers, angles and text as the report page writes them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Text made safe for HTML, in elements and in quoted attributes.
std::string escape_html(std::string_view text);

/// A table's cell; number_cell keeps to the right and on one line. The content is HTML already.
std::string cell(const std::string& html);
std::string number_cell(const std::string& html);

/// "0.3142", with so many significant digits; an en dash where there is no value (NaN), an infinity sign
/// where open.
std::string number(double value, int digits = 4);

/// A value rounded where its sd says: decimals such that sd keeps two significant digits: (0.100123, 0.00031)
/// gives "0.10012". Without a usable sd: number(value).
std::string rounded_to_sd(double value, double sd);

/// "0.09952 to 0.10073", rounded where sd says; an en dash where there is no interval.
std::string interval_words(const ReportInterval& range, double sd);

/// Sentences as a list.
std::string html_list(const std::vector<std::string>& sentences);

/// "0.10012 ± 0.00031"; the value alone without a usable sd.
std::string value_and_sd(double value, double sd);

/// "5π/6" for multiples of pi/12 (within 1e-4 rad), else "1.234 rad".
std::string angle(double rad);

/// A parameter as people write and explain it.
struct ParameterWords {
  std::string symbol;   ///< HTML: "μ<sub>1</sub>"
  std::string unit;     ///< "" for a pure number
  std::string meaning;  ///< one line
};

/// By its campaign key ("mu1", "phase_lag_rad", ...); an unknown key stands for itself.
ParameterWords parameter_words(const std::string& key);

/// An observable as people write it: "v_mm_s" -> "v (mm/s)".
std::string observable_words(const std::string& observable);

/// Base 64 (RFC 4648), for pictures inside the page.
std::string base64(const std::vector<unsigned char>& bytes);

}  // namespace tribotrack::apps
