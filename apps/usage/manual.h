// Manual pages, in the language of man(7), and completion for shells, from the command line itself.
#pragma once

#include <string>
#include <vector>

#include "apps/usage/command_line.h"

namespace tribotrack::apps {

/// tribotrack(1) for the first of `all`, tribotrack-NAME(1) for the others. The same version gives the same
/// bytes.
std::string manual_page(const CommandFacts& command, const std::vector<CommandFacts>& all,
                        const std::string& version);

/// tribotrack-campaign(5): `reference` with headings that begin at the margin and indented lines.
std::string campaign_manual(const std::string& reference, const std::string& version);

/// For "bash", "zsh" or "fish": commands, their options, and the words that options take. Empty for another
/// shell.
std::string completion(const std::vector<CommandFacts>& all, const std::string& shell);

}  // namespace tribotrack::apps
