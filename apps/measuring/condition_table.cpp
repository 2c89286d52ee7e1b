#include "apps/measuring/condition_table.h"

#include <fmt/format.h>

#include "apps/text/number_text.h"

namespace tribotrack::apps {

namespace {

Json value_json(const std::optional<fit::Estimate>& estimate) {
  return estimate ? finite_json(estimate->value) : Json();
}

/// Null for an exact value.
Json sd_json(const std::optional<fit::Estimate>& estimate) {
  return estimate && estimate->sd > 0 ? finite_json(estimate->sd) : Json();
}

std::string text_of(const fit::Estimate& estimate) {
  if (!(estimate.sd > 0)) return fmt::format("{:.6g}", estimate.value);
  return quoted(estimate.value, estimate.sd);
}

}  // namespace

Json conditions_json(const std::vector<ConditionRow>& rows) {
  Json json = Json::array();
  for (const ConditionRow& row : rows)
    json.push_back({{"quantity", row.quantity},
                    {"given", value_json(row.given)},
                    {"given_sd", sd_json(row.given)},
                    {"measured", value_json(row.measured)},
                    {"sd", sd_json(row.measured)},
                    {"difference_in_sd", row.difference_in_sd ? finite_json(*row.difference_in_sd) : Json()},
                    {"runs", row.runs},
                    {"p_value", finite_json(row.p_value)},
                    {"used", finite_json(row.used.value)},
                    {"used_sd", sd_json(row.used)},
                    {"from", row.from}});
  return json;
}

std::string conditions_text(const std::vector<ConditionRow>& rows) {
  if (rows.empty()) return "";
  std::string text = fmt::format("{:<26}{:>22}{:>28}{:>18}   {}\n", "condition", "given", "measured",
                                 "difference in sd", "used");
  for (const ConditionRow& row : rows)
    text += fmt::format("{:<26}{:>22}{:>28}{:>18}   {}\n", row.quantity,
                        row.given ? text_of(*row.given) : "-", row.measured ? text_of(*row.measured) : "-",
                        row.difference_in_sd ? fmt::format("{:.1f}", *row.difference_in_sd) : "-",
                        fmt::format("{}, {}", text_of(row.used), row.from));
  return text;
}

}  // namespace tribotrack::apps
