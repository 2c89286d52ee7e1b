#include "apps/text/given_sd.h"

#include <fmt/format.h>

namespace tribotrack::apps {

std::optional<double> read_sd(StrictTable& table, const std::string& quantity) {
  const std::string key = quantity + "_sd";
  const auto sd = quantity.ends_with("_rad") ? table.angle(key) : table.number(key);
  if (!sd) return std::nullopt;
  if (!table.has(quantity))
    table.fail(key,
               fmt::format("is the sd of `{}`, which is not given here: give both, or neither", quantity));
  if (!(*sd > 0))
    table.fail(
        key, fmt::format("must be greater than 0, not {}: leave it out where `{}` is exact", *sd, quantity));
  return sd;
}

}  // namespace tribotrack::apps
