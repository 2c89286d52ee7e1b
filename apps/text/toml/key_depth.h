// Keys of TOML that nest too deeply.
#pragma once

#include <string>
#include <string_view>

namespace tribotrack::apps {

/// Each dot in a key such as `fit.prior.mu1` is a table in a table, and the library follows and frees these
/// by calling itself: thousands of them would fill the stack. Throws InvalidInput with file, line and column.
void require_shallow_keys(std::string_view text, const std::string& name);

}  // namespace tribotrack::apps
