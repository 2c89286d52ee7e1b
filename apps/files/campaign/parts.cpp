#include "apps/files/campaign/parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

std::vector<std::string> names_of(const std::vector<PartSection>& parts) {
  std::vector<std::string> names;
  for (const PartSection& part : parts) names.push_back(part.name);
  return names;
}

bool is_place(const PartSection& part) {
  return part.disc_px || part.template_px;
}

/// Does the run show this part?
bool shows(const CampaignRun& run, const PartSection& part) {
  if (!run.parts.empty()) return run.parts.contains(part.name);
  return run.part.empty() || run.part == part.name;
}

/// The run as that of one part: where it lies at first is said by the run, else by the part.
CampaignRun run_of_part(CampaignRun run, const PartSection& part) {
  if (const auto place = run.parts.find(part.name); place != run.parts.end()) {
    run.disc_px = place->second.disc_px;
    run.template_px = place->second.template_px;
  } else if (!run.disc_px && !run.template_px) {
    run.disc_px = part.disc_px;
    run.template_px = part.template_px;
  }
  run.parts.clear();
  run.part = part.name;
  return run;
}

void require_known(const Campaign& campaign, const CampaignRun& run, const std::string& name) {
  const std::vector<std::string> names = names_of(campaign.parts);
  if (std::ranges::find(names, name) != names.end()) return;
  throw InvalidInput(fmt::format("{}: there is no [[part]] named \"{}\"; there are: {}", run.place, name,
                                 fmt::join(names, ", ")));
}

}  // namespace

void read_part_or_parts(StrictTable& top, Campaign& campaign) {
  if (!top.is_list("part")) {
    if (auto table = top.table("part")) campaign.part = read_part(*table, WithSd::yes);
    return;
  }
  std::set<std::string> taken;
  for (StrictTable& table : top.tables("part")) {
    campaign.parts.push_back(read_part(table, WithSd::yes));
    const std::string& name = campaign.parts.back().name;
    if (name.empty()) table.fail("name", "is missing: each of several [[part]] has a `name`");
    if (name.find('/') != std::string::npos || name == "." || name == "..")
      table.fail("name", fmt::format("\"{}\" cannot be a folder's name", name));
    if (!taken.insert(name).second)
      table.fail("name", fmt::format("\"{}\" is taken by an earlier part", name));
  }
  if (campaign.parts.size() != 1) return;
  campaign.part = campaign.parts.front();
  campaign.parts.clear();
}

void check_parts(const Campaign& campaign) {
  if (campaign.parts.empty()) {
    for (const CampaignRun& run : campaign.runs)
      if (!run.parts.empty() || (!run.part.empty() && run.part != campaign.part.name))
        throw InvalidInput(
            fmt::format("{}: names a part, but the campaign has no [[part]] of that name", run.place));
    return;
  }
  if (!campaign.data.tables.empty())
    throw InvalidInput(fmt::format(
        "{}: a table of alpha and v is one part's, and this campaign has {}: give it a campaign of its own",
        campaign.file.string(), campaign.parts.size()));
  for (const CampaignRun& run : campaign.runs) {
    if (!run.part.empty()) require_known(campaign, run, run.part);
    for (const auto& [name, place] : run.parts) require_known(campaign, run, name);
    if (!run.part.empty() || !run.parts.empty()) continue;
    const bool placed = std::ranges::all_of(campaign.parts, is_place);
    if (!run.video || !placed || run.disc_px || run.template_px)
      throw InvalidInput(fmt::format(
          "{}: run \"{}\": does not say where each part lies; give parts = {{ {} = [X, Y, R] }} ([X, Y, "
          "WIDTH, "
          "HEIGHT] for a part of any shape), or part = \"{}\" where it shows one; `tribotrack probe VIDEO "
          "--picture FIRST.png` shows what lies where",
          run.place, run.name, fmt::join(names_of(campaign.parts), " = [X, Y, R], "),
          campaign.parts.front().name));
  }
}

std::vector<Campaign> campaigns_by_part(const Campaign& campaign) {
  if (campaign.parts.empty()) return {campaign};
  std::vector<Campaign> campaigns;
  for (const PartSection& part : campaign.parts) {
    Campaign one = campaign;
    one.parts.clear();
    one.part = part;
    if (one.title.empty()) one.title = one.file.stem().string();
    one.title += ": " + part.name;
    one.runs.clear();
    for (const CampaignRun& run : campaign.runs)
      if (shows(run, part)) one.runs.push_back(run_of_part(run, part));
    if (one.runs.empty())
      throw InvalidInput(fmt::format("{}: no [[run]] shows the part \"{}\"; take it out, or add one",
                                     campaign.file.string(), part.name));
    campaigns.push_back(std::move(one));
  }
  return campaigns;
}

Campaign campaign_of_part(const Campaign& campaign, const std::string& part) {
  const std::vector<std::string> names = names_of(campaign.parts);
  if (part.empty() && names.empty()) return campaign;
  const auto found = std::ranges::find(names, part);
  if (found == names.end())
    throw InvalidInput(
        names.empty()
            ? fmt::format("{}: has no [[part]] named \"{}\"", campaign.file.string(), part)
            : fmt::format("{}: has several parts, each with a fit of its own: {}; say which one is meant "
                          "(`run` and `fit` take --part NAME)",
                          campaign.file.string(), fmt::join(names, ", ")));
  return campaigns_by_part(campaign)[static_cast<std::size_t>(found - names.begin())];
}

}  // namespace tribotrack::apps
