#include "apps/survey/campaign_keys.h"

#include <gmock/gmock.h>

#include <fstream>
#include <set>
#include <sstream>

#include "apps/chromium.h"
#include "apps/files/campaign/campaign.h"
#include "apps/program/errors.h"
#include "apps/survey/campaign_draft.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

std::string full_name(std::string_view section, std::string_view key) {
  return std::string(section) + "." + std::string(key);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(CampaignKeys, AreThoseThatTheReaderAsksFor) {
  std::set<std::string> asked, explained;
  for (const AskedKey& key : keys_asked_of_campaign())
    if (key.section != "fit.guess" || key.key == "mu1") asked.insert(full_name(key.section, key.key));
  for (const CampaignKey& key : campaign_keys()) {
    EXPECT_TRUE(explained.insert(full_name(key.section, key.key)).second) << key.key << " twice";
    EXPECT_FALSE(key.example.empty());
  }
  EXPECT_EQ(asked, explained);
}

TEST(CampaignKeys, TheReferenceNamesEveryKeyWithItsKind) {
  const std::string reference = campaign_reference();
  for (const CampaignKey& key : campaign_keys())
    EXPECT_THAT(reference, HasSubstr(std::string(key.key) + " = " + std::string(key.example)));
  EXPECT_THAT(reference, HasSubstr("number above 0"));
  EXPECT_THAT(reference, HasSubstr("\"rest\", \"circling\", \"steady\""));
  for (const std::string& line : lines_of(reference)) EXPECT_LE(line.size(), 180U) << line;
}

class Draft : public testing::Test {
 protected:
  /// A draft with one run, and the lines before `uncommented` taken out of their comments.
  std::string complaint(const std::set<std::string>& uncommented) const {
    std::string text, section;
    for (std::string line : lines_of(draft_)) {
      const bool comment = line.starts_with("# ");
      std::string plain = comment ? line.substr(2) : line;
      if (plain.starts_with('[')) section = plain.substr(0, plain.find_last_of(']') + 1);
      std::erase_if(section, [](char c) { return c == '[' || c == ']'; });
      const std::string key = full_name(section, plain.substr(0, plain.find(" =")));
      const bool header = comment && plain.starts_with('[') && !plain.starts_with("[[run]]:");
      const bool needed =
          header && std::any_of(uncommented.begin(), uncommented.end(), [&](const std::string& name) {
            return name.substr(0, name.find_last_of('.')) == section && section != "run";
          });
      text += (needed || (comment && uncommented.contains(key)) ? plain : line) + "\n";
    }
    const std::filesystem::path file = folder_.path() / "campaign.toml";
    std::ofstream(file) << text;
    try {
      read_campaign(file);
      return "";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  }
  test::TemporaryFolder folder_;
  std::string draft_ = [] {
    CampaignDraft draft;
    draft.tables["part"]["diameter_mm"] = {"6.0", "given"};
    draft.runs = {{{"video", {"\"a.cine\"", ""}}, {"phi_rad", {"0", ""}}, {"dtau_rad", {"1", ""}}}};
    return toml_of(draft);
  }();
};

TEST_F(Draft, ReadsAsItIsWritten) {
  EXPECT_EQ(complaint({}), "");
}

// Every commented line is valid TOML of the right type, at a place where the reader knows it.
TEST_F(Draft, EveryKeyIsValidWithItsCommentSignRemoved) {
  for (const CampaignKey& key : campaign_keys()) {
    std::set<std::string> lines = {full_name(key.section, key.key)};
    std::istringstream with{std::string(key.with)};
    for (std::string other; std::getline(with >> std::ws, other, ',');)
      for (const char* section : {"part", "camera"})
        lines.insert(
            full_name(other == "height_mm" || other == "working_distance_mm" ? section : key.section, other));
    const std::string said = complaint(lines);
    for (const char* wrong : {"not a known key", "must be", "expected", "needs "})
      EXPECT_THAT(said, testing::Not(HasSubstr(wrong))) << key.section << "." << key.key;
  }
}

TEST_F(Draft, WithoutRunsItAsksForThem) {
  const std::filesystem::path file = folder_.path() / "campaign.toml";
  std::ofstream(file) << toml_of({});
  EXPECT_THROW(read_campaign(file), InvalidInput);
  EXPECT_TRUE(read_campaign(file, Runs::may_be_missing).runs.empty());
}

}  // namespace
}  // namespace tribotrack::apps
