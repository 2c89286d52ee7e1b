#include "apps/files/campaign/keys.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
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

TEST(LastDigit, IsHalfAUnitEvenlyDistributed) {
  const double root = std::sqrt(12), degree = std::numbers::pi / 180;
  for (const auto& [written, unit] : {std::pair{"0.28", 0.01},
                                      {"0.280", 0.001},
                                      {"-0.05", 0.001},
                                      {"0.3", 0.01},
                                      {"1.0", 0.1},
                                      {"62.8", 0.1},
                                      {"0.005", 0.0001},
                                      {"2.50e-3", 1e-5},
                                      {"1e-4", 1e-5},
                                      {"1_000.5", 0.1},
                                      {"45.5deg", 0.1 * degree},
                                      {"-0.10 deg", 0.01 * degree}})
    EXPECT_NEAR(last_digit_sd(written) * root, unit, 1e-12 * unit) << written;
  for (const char* set : {"0", "280", "0.0", "pi/2", "11pi/9", "0.5pi", "45deg", "rest", ""})
    EXPECT_EQ(last_digit_sd(set), 0) << set;
}

TEST_F(CampaignKeys, HoldOutNamesDrivenRunsButNotAll) {
  const std::string two = "name = \"a\"\n" + kRun.substr(kRun.find('\n') + 1);
  const auto with = [&](const std::string& names) {
    return "[fit]\nhold_out = [" + names + "]\n[[run]]\n" + two + "[[run]]\nname = \"b\"\n" +
           kRun.substr(kRun.find('\n') + 1);
  };
  put(in_folder("c.toml"), with("\"b\""));
  EXPECT_EQ(read_campaign(in_folder("c.toml")).fit.hold_out, std::vector<std::string>{"b"});
  EXPECT_THAT(complaint(with("\"c\"")),
              HasSubstr("c.toml:2:1: `hold_out` in [fit] names \"c\", which is no run"));
  EXPECT_THAT(complaint(with("\"a\", \"b\"")), HasSubstr("names every run; leave some to fit to"));
}

TEST_F(CampaignKeys, ExactIsEverythingOrAListOfNames) {
  const auto exact = [&](const std::string& value) {
    put(in_folder("c.toml"), "[fit]\nexact = " + value + "\n[platform]\namplitude_mm = 0.280\n" + kRun);
    return read_campaign(in_folder("c.toml"));
  };
  EXPECT_TRUE(exact("true").fit.exact.holds("tilt_x_rad"));
  EXPECT_FALSE(exact("false").fit.exact.holds("tilt_x_rad"));
  const Campaign some = exact("[\"frequency_hz\", \"diameter_mm\", \"start_phase_rad\"]");
  EXPECT_TRUE(some.fit.exact.holds("angular_frequency_rad_s"));
  EXPECT_TRUE(some.fit.exact.holds("start_phase_rad"));
  EXPECT_FALSE(some.fit.exact.holds("amplitude_mm"));
  EXPECT_THAT(
      complaint("[fit]\nexact = [\"tilt_x_deg\"]\n" + kRun),
      HasSubstr("c.toml:2:1: `exact` in [fit] names \"tilt_x_deg\", which is no quantity with an sd; did "
                "you mean \"tilt_x_rad\"?"));
  EXPECT_THAT(
      complaint("[fit]\nexact = [\"amplitude_mm\"]\n[platform]\namplitude_mm = 1\namplitude_mm_sd "
                "= 0.1\n" +
                kRun),
      HasSubstr("c.toml:5:1: `amplitude_mm_sd` in [platform] and exact = [\"amplitude_mm\"] in [fit]"));
}

TEST_F(CampaignKeys, WithoutAnSdTheLastDigitOrTheTradeTells) {
  put(in_folder("c.toml"), "[platform]\namplitude_mm = 0.28\nfrequency_hz = 10.00\n" + kRun);
  const Campaign campaign = read_campaign(in_folder("c.toml"));
  const auto sd = [&](const char* key, double value, const Digits& digits) {
    return default_sd(campaign.fit.exact, key, value, digits);
  };
  const Digits& digits = campaign.platform.digits;
  EXPECT_NEAR(sd("amplitude_mm", 0.28, digits), 0.01 / std::sqrt(12), 1e-15);
  EXPECT_NEAR(sd("amplitude_mm", 0.28, {}), 0.0014, 1e-15);
  EXPECT_NEAR(sd("angular_frequency_rad_s", 62.83, digits), 0.01 / std::sqrt(12) * 2 * std::numbers::pi,
              1e-12);
  EXPECT_NEAR(sd("diameter_mm", 6, {}), 0.02, 1e-15);
  EXPECT_NEAR(sd("phase_shift_rad", 1, {}), std::numbers::pi / 180, 1e-15);
  EXPECT_EQ(sd("phi_rad", 1, {}), 0);
  EXPECT_EQ(sd("gravity_m_s2", 9.81, {{"gravity_m_s2", 0.003}}), 0);
  EXPECT_EQ(default_sd({true, {}}, "amplitude_mm", 0.28, digits), 0);
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
