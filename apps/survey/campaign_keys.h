// Every key that a campaign may hold, with an example and what it means: what `init` writes and `help
// campaign` shows.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace tribotrack::apps {

struct CampaignSection {
  std::string_view name;    ///< "platform", "fit.fixed", "run"; "" for what stands before all of them
  std::string_view remark;  ///< what it is for, one line
  bool repeated = false;    ///< [[run]]
};

struct CampaignKey {
  std::string_view section, key;
  std::string_view example;  ///< as TOML
  std::string_view meaning;  ///< one line
  std::string_view with{};   ///< another key of the section without which it is refused
};

/// In the order of a campaign. They must be all that the reader asks for (keys_asked_of_campaign): a test
/// compares them.
std::span<const CampaignSection> campaign_sections();
std::span<const CampaignKey> campaign_keys();

/// `help campaign`: all sections, keys, kinds of values and meanings.
std::string campaign_reference();

}  // namespace tribotrack::apps
