#include "apps/files/campaign/keys.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include "apps/program.h"
#include "apps/program/errors.h"
#include "apps/survey/campaign_draft.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

const std::string kRun =
    "[[run]]\nphi_rad = 0\ndtau_rad = 1\nalpha_rad = 1\nalpha_sd_rad = 0.1\nv_mm_s = 2\nv_sd_mm_s = 0.1\n";

class CampaignKeys : public ProgramTest {
 protected:
  std::string complaint(const std::string& text) const {
    put(in_folder("c.toml"), text);
    return complaint_of([&] { read_campaign(in_folder("c.toml")); });
  }
  /// The keys that the reader lists where it is asked for one that nobody knows.
  std::set<std::string> known_in(const std::string& section) const {
    const std::string unknown = "zzzzzzzzzzzzzzzz = 1\n";
    const std::string said = complaint(section.empty()    ? unknown + kRun
                                       : section == "run" ? kRun + unknown
                                                          : "[" + section + "]\n" + unknown + kRun);
    std::set<std::string> keys;
    const auto at = said.find("known here: ");
    EXPECT_NE(at, std::string::npos) << said;
    std::istringstream list(said.substr(at + 12));
    for (std::string key; std::getline(list >> std::ws, key, ',');) keys.insert(key);
    return keys;
  }
};

/// Those of a table's schema that have no other name.
std::set<std::string> properties(const Json& table) {
  std::set<std::string> names;
  for (const auto& [name, schema] : table.at("properties").items())
    if (!schema.value("description", "").starts_with("another name of")) names.insert(name);
  return names;
}

TEST_F(CampaignKeys, OfTheSchemaAreThoseThatTheReaderAsksFor) {
  const Json schema = campaign_schema();
  const Json& sections = schema.at("properties");
  EXPECT_EQ(known_in(""), properties(schema));
  for (const char* section : {"platform", "camera", "scope", "data", "fit"})
    EXPECT_EQ(known_in(section), properties(sections.at(section))) << section;
  for (const char* section : {"fixed", "guess"})
    EXPECT_EQ(known_in(std::string("fit.") + section),
              properties(sections.at("fit").at("properties").at(section)));
  EXPECT_EQ(known_in("part"), properties(sections.at("part").at("oneOf").at(0)));
  EXPECT_EQ(known_in("run"), properties(sections.at("run").at("items")));
}

TEST_F(CampaignKeys, TheSchemaTellsKindsDefaultsAndWhatGoesTogether) {
  const Json schema = campaign_schema();
  const Json& platform = schema.at("properties").at("platform");
  EXPECT_EQ(platform["properties"]["amplitude_mm"]["minimum"], 0);
  EXPECT_EQ(platform["properties"]["gravity_m_s2"]["default"], 9.81);
  EXPECT_EQ(platform["dependentRequired"]["gravity_m_s2_sd"], Json::array({"gravity_m_s2"}));
  EXPECT_EQ(platform["additionalProperties"], false);
  const Json& fit = schema.at("properties").at("fit").at("properties");
  EXPECT_EQ(fit["start"]["enum"], Json::array({"rest", "circling", "steady"}));
  EXPECT_EQ(fit["cycles"]["default"], 20);
  EXPECT_EQ(fit["prior"]["properties"]["mm_per_px"]["required"], Json::array({"mean", "sd"}));
}

TEST_F(CampaignKeys, TheReferenceNamesEveryKeyWithItsKind) {
  const std::string reference = campaign_reference();
  for (const CampaignSection& section : campaign_sections())
    for (const KeyFacts& key : section.keys) {
      EXPECT_FALSE(key.example.empty()) << key.name;
      EXPECT_THAT(reference, HasSubstr(key.name + " = " + key.example + " "));
    }
  EXPECT_THAT(reference, HasSubstr("number above 0"));
  EXPECT_THAT(reference, HasSubstr("\"rest\", \"circling\", \"steady\""));
  for (const std::string& line : lines_of(reference)) EXPECT_LE(line.size(), 180U) << line;
}

TEST_F(CampaignKeys, AQuantityHasOneOfItsNames) {
  put(in_folder("c.toml"), "[platform]\nfrequency_hz = 10\nfrequency_hz_sd = 0.1\nepsilon_rad = 1\n" + kRun);
  const Campaign campaign = read_campaign(in_folder("c.toml"));
  EXPECT_DOUBLE_EQ(*campaign.platform.angular_frequency, 20 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(*campaign.platform.angular_frequency_sd, 0.2 * std::numbers::pi);
  EXPECT_EQ(campaign.platform.phase_shift, 1);
  EXPECT_THAT(complaint("[platform]\nomega_rad_s = 60\nfrequency_hz = 10\n" + kRun),
              HasSubstr("c.toml:3:1: `frequency_hz` in [platform] and `omega_rad_s` mean the same"));
}

/// A key with its example, after those that it needs.
std::string lines_with(const CampaignSection& section, const KeyFacts& key) {
  const auto needed = [&](const std::string& name) -> std::string {
    const auto found = std::ranges::find(section.keys, name, &KeyFacts::name);
    return found == section.keys.end() || name == key.name ? "" : lines_with(section, *found);
  };
  return needed(key.quantity()) + needed(key.with) + key.name + " = " + key.example + "\n";
}

/// A campaign that holds these lines in this section.
std::string campaign_with(const CampaignSection& section, const std::string& lines) {
  if (section.name.empty()) return lines + kRun;
  if (!section.repeated) return "[" + section.name + "]\n" + lines + kRun;
  const bool measured = lines.starts_with("alpha_") || lines.starts_with("v_");
  std::string run = "[[run]]\n" + lines;
  for (const std::string line : {"phi_rad = 0", "dtau_rad = 1", "video = \"a.cine\"", "alpha_rad = 1",
                                 "alpha_sd_rad = 0.1", "v_mm_s = 2", "v_sd_mm_s = 0.1"}) {
    const bool angles = line.starts_with("phi") || line.starts_with("dtau");
    const bool other_source =
        line.starts_with("video") ? measured || run.find("\ntrack = ") != run.npos : !measured;
    if (!angles && other_source) continue;
    if (run.find("\n" + line.substr(0, line.find('=') + 1)) == run.npos) run += line + "\n";
  }
  return run;
}

TEST_F(CampaignKeys, ExamplesAreRead) {
  const std::map<std::string, std::string> of_other_sections = {
      {"part.height_mm_sd", "[camera]\nworking_distance_mm = 100\n"},
      {"camera.working_distance_mm_sd", "[part]\nheight_mm = 0.8\n"}};
  for (const CampaignSection& section : campaign_sections())
    for (const KeyFacts& key : section.keys) {
      const std::string name = section.name + "." + key.name;
      const auto other = of_other_sections.find(name);
      const std::string said = complaint(campaign_with(section, lines_with(section, key)) +
                                         (other == of_other_sections.end() ? "" : other->second));
      for (const char* wrong : {"not a known key", "must be", "expected", "needs "})
        EXPECT_THAT(said, testing::Not(HasSubstr(wrong))) << name;
    }
}

TEST_F(CampaignKeys, ADraftReadsAsItIsWritten) {
  CampaignDraft draft;
  draft.tables["part"]["diameter_mm"] = {"6.0", "given"};
  draft.runs = {{{"video", {"\"a.cine\"", ""}}, {"phi_rad", {"0", ""}}, {"dtau_rad", {"1", ""}}}};
  EXPECT_EQ(complaint(toml_of(draft)), "no complaint");
  EXPECT_THAT(complaint(toml_of({})), HasSubstr("has no [[run]]"));
  EXPECT_TRUE(read_campaign(in_folder("c.toml"), Runs::may_be_missing).runs.empty());
}

}  // namespace
}  // namespace tribotrack::apps
