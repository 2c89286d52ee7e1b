// A page's template and what goes into it.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "apps/text/json.h"

namespace tribotrack::apps {

using PageParts = std::map<std::string, std::string_view, std::less<>>;

/// Replaces each {{name}} of the template once, in one pass: what is put in is not looked at again. Throws
/// std::logic_error for a name that is not among the parts.
std::string fill_template(std::string_view page, const PageParts& parts);

/// JSON inside a script element: "<" occurs only inside strings, and written as an escape nothing in them can
/// close the element.
std::string json_for_script(const Json& json);

}  // namespace tribotrack::apps
