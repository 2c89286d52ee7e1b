// A campaign's text changed as a person would change it: a key where it stands, comments and order kept.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/text/json.h"

namespace tribotrack::apps {

struct CampaignEdit {
  std::string section;  ///< "camera", "fit.guess"; "run" for that of `run`
  std::size_t run = 0;  ///< which [[run]] of the file, from 0
  std::string key;
  std::string value;  ///< as TOML; empty: the key becomes a comment
};

/// Values as they are written, by section: numbers and texts as texts, lists as lists; "run" is a list.
Json values_of_campaign(const std::string& text, const std::string& name);

/// The text with these changes, in their order. A value takes the place of the old one; a key that stands
/// there as a comment, as `init` drafts it, is made to hold; else a line is added to its section, and a
/// section to the file. What `init` asked for at the top leaves once it is answered; nothing else changes:
/// throws InvalidInput where the file's form does not allow it (inline and dotted tables), where the value is
/// no TOML, and where there is no such run.
std::string with_edits(std::string text, const std::vector<CampaignEdit>& edits, const std::string& name);

/// The text with a [[run]] of a recording at its end.
std::string with_recording(std::string text, const std::string& recording);

}  // namespace tribotrack::apps
