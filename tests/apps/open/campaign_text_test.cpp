#include "apps/open/campaign_text.h"

#include <gmock/gmock.h>

#include "apps/program.h"
#include "apps/survey/campaign_draft.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

std::string set(const std::string& text, const std::string& section, const std::string& key,
                const std::string& value, std::size_t run = 0) {
  return with_edits(text, {{section, run, key, value}}, "c.toml");
}

TEST(CampaignText, AValueTakesThePlaceOfTheOldOneAndNothingElseMoves) {
  const std::string text =
      "# mine\n[camera]\n  mm_per_px = 0.020   # by the ruler\ndisc_px = [1,\n  2, # why\n  "
      "3]\n[[run]]\nvideo = \"a # b.cine\"\n\n"
      "[[run]]\nvideo = 'b.cine'\nphi_rad = \"45deg\" # set\n";
  EXPECT_EQ(set(text, "camera", "mm_per_px", "0.021"),
            "# mine\n[camera]\n  mm_per_px = 0.021   # by the ruler\ndisc_px = [1,\n  2, # why\n  "
            "3]\n[[run]]\nvideo = \"a # b.cine\"\n\n"
            "[[run]]\nvideo = 'b.cine'\nphi_rad = \"45deg\" # set\n");
  EXPECT_THAT(set(text, "camera", "disc_px", "[4, 5, 6]"),
              HasSubstr("# by the ruler\ndisc_px = [4, 5, 6]\n[[run]]"));
  EXPECT_THAT(set(text, "run", "phi_rad", "\"90deg\"", 1),
              HasSubstr("'b.cine'\nphi_rad = \"90deg\" # set\n"));
  EXPECT_THAT(set(text, "run", "phi_rad", "0", 0), HasSubstr("\"a # b.cine\"\nphi_rad = 0\n\n[[run]]"));
  EXPECT_THAT(set(text, "run", "phi_rad", "", 1), HasSubstr("\n# phi_rad = \"45deg\" # set\n"));
  EXPECT_THAT(set(text, "part", "diameter_mm", "6"),
              HasSubstr("[part]\ndiameter_mm = 6\n\n[[run]]\nvideo = \"a"));
}

// Of what `init` drafts, comments become keys where they stand, and every key of the draft can be set.
TEST(CampaignText, ADraftIsFilledInAsByHand) {
  CampaignDraft draft;
  draft.runs.resize(2);
  for (DraftTable& run : draft.runs) {
    run["video"] = {"\"a.cine\"", ""};
    run["phi_rad"] = {"\"0deg\"", "not in the recording's name: fill it in", true};
  }
  const std::string text = toml_of(draft);
  const std::string filled = set(text, "run", "phi_rad", "\"45deg\"", 1);
  EXPECT_THAT(filled, HasSubstr("\nphi_rad = \"45deg\"\n"));
  EXPECT_EQ(std::count(filled.begin(), filled.end(), '\n'), std::count(text.begin(), text.end(), '\n'));
  EXPECT_THAT(set(text, "camera", "marker_px", "[1, 2, 3]"), HasSubstr("\nmarker_px = [1, 2, 3]"));
  const std::string scope = set(text, "scope", "carrier_hz", "5000");
  EXPECT_THAT(scope, HasSubstr("\n[scope]"));
  EXPECT_THAT(scope, HasSubstr("\ncarrier_hz = 5000"));
  EXPECT_EQ(values_of_campaign(with_recording(text, "b.cine"), "c")["run"].size(), 3u);
}

TEST(CampaignText, WhatCannotBeChangedSafelyIsRefused) {
  const auto complaint = [](const std::string& text, const CampaignEdit& edit) {
    return complaint_of([&] { with_edits(text, {edit}, "c.toml"); });
  };
  EXPECT_EQ(set("camera = { mm_per_px = 1 }\n", "camera", "mm_per_px", "2"), "camera = { mm_per_px = 2 }\n");
  EXPECT_EQ(set("camera.mm_per_px = 1\n", "camera", "mm_per_px", "2"), "camera.mm_per_px = 2\n");
  EXPECT_THAT(complaint("camera = { mm_per_px = 1 }\n", {"camera", 0, "fps", "2"}),
              HasSubstr("only a person"));
  EXPECT_THAT(complaint("camera.mm_per_px = 1\n", {"camera", 0, "fps", "2"}), HasSubstr("only a person"));
  EXPECT_THAT(complaint("", {"camera", 0, "mm_per_px", "1\n[fit]"}), HasSubstr("one line"));
  EXPECT_THAT(complaint("", {"camera", 0, "mm_per_px", "1, x = 2"}), HasSubstr("mm_per_px:1:"));
  EXPECT_THAT(complaint("", {"camera]", 0, "x", "1"}), HasSubstr("no such key"));
  EXPECT_THAT(complaint("", {"run", 0, "phi_rad", "1"}), HasSubstr("no [[run]] number 1"));
}

}  // namespace
}  // namespace tribotrack::apps
