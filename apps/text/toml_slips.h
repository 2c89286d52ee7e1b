// What a user meant by a text that is no TOML.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tribotrack::apps {

/// ": is ...; save it as UTF-8", to follow the file's name, where a text is in another encoding or is no text
/// at all; with ":LINE:COLUMN" before it where one character shows it. Empty for UTF-8.
std::string encoding_slip(std::string_view text);

/// What is wrong at this place, at which the parser gave up, and what to write. `description`: the parser's
/// words, of which only a key that is given twice is used.
std::string toml_slip(std::string_view text, std::size_t line, std::size_t column,
                      std::string_view description);

/// The byte at a place, which counts lines and characters from 1.
std::size_t offset_of(std::string_view text, std::size_t line, std::size_t column);

// Keys of TOML that nest too deeply.

/// Each dot in a key such as `fit.prior.mu1` is a table in a table, and the library follows and frees these
/// by calling itself: thousands of them would fill the stack. Throws InvalidInput with file, line and column.
void require_shallow_keys(std::string_view text, const std::string& name);

}  // namespace tribotrack::apps
