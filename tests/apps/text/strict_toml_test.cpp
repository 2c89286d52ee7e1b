#include "apps/text/strict_toml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

template <class Action>
std::string complaint(const Action& action) {
  try {
    action();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(StrictToml, HandsOutWhatIsThere) {
  StrictTable t = StrictTable::parse(
      "a = 1\nb = 2.5\nc = \"11pi/9\"\nd = [1, 2.5]\ne = \"word\"\nf = true\n[g]\nx = 3\n[[h]]\n[[h]]\n",
      "t.toml");
  EXPECT_EQ(t.number("a"), 1.0);
  EXPECT_EQ(t.positive("b"), 2.5);
  EXPECT_EQ(t.angle("c"), 11 * std::numbers::pi / 9);
  EXPECT_EQ(t.numbers("d", 2), (std::vector<double>{1, 2.5}));
  EXPECT_EQ(t.text("e"), "word");
  EXPECT_EQ(t.boolean("f"), true);
  EXPECT_EQ(t.table("g")->integer("x"), 3);
  EXPECT_EQ(t.tables("h").size(), 2u);
  EXPECT_FALSE(t.number("not there"));
  t.finish();
}

TEST(StrictToml, ErrorsNameFileLineColumnAndRemedy) {
  StrictTable t = StrictTable::parse("\namplitude_mm = \"x\"\n", "t.toml");
  const std::string text = complaint([&] { t.number("amplitude_mm"); });
  EXPECT_THAT(text, HasSubstr("t.toml:2:1"));
  EXPECT_THAT(text, HasSubstr("`amplitude_mm`"));
  EXPECT_THAT(text, HasSubstr("number"));
}

TEST(StrictToml, AnUnknownKeyIsNamedWithTheNearestOne) {
  StrictTable t = StrictTable::parse("[fit]\ncycels = 20\n", "t.toml");
  StrictTable fit = *t.table("fit");
  fit.integer("cycles");
  fit.text("start");
  const std::string text = complaint([&] { fit.finish(); });
  EXPECT_THAT(text, HasSubstr("t.toml:2:1"));
  EXPECT_THAT(text, HasSubstr("cycels"));
  EXPECT_THAT(text, HasSubstr("did you mean `cycles`"));
}

TEST(StrictToml, AKeyOfAnotherTableIsSentThere) {
  StrictTable t =
      StrictTable::parse("[camera]\ndiameter_mm = 6\n[fit]\nmu1 = 0.2\ntitle = \"t\"\n", "t.toml");
  t.say_where_keys_belong([] {
    return std::vector<AskedKey>{{"", "title", "text"},
                                 {"part", "diameter_mm", "number"},
                                 {"fit.guess", "mu1", "number"},
                                 {"run", "mu1", "number"}};
  });
  StrictTable camera = *t.table("camera"), fit = *t.table("fit");
  EXPECT_EQ(complaint([&] { camera.finish(); }),
            "t.toml:2:1: `diameter_mm` in [camera] does not belong here but in [part]");
  EXPECT_EQ(complaint([&] { fit.finish(); }),
            "t.toml:4:1: `mu1` in [fit] does not belong here but in [fit.guess] or in [[run]]");
  fit.number("mu1");
  EXPECT_THAT(complaint([&] { fit.finish(); }),
              HasSubstr("at the top of the file, before the first [table]"));
}

TEST(StrictToml, DuplicateKeysAndBrokenSyntaxHaveAPlace) {
  EXPECT_THAT(complaint([] { StrictTable::parse("a = 1\na = 2\n", "t.toml"); }), HasSubstr("t.toml:2:"));
  EXPECT_THAT(complaint([] { StrictTable::parse("a = \n", "t.toml"); }), HasSubstr("t.toml:1:"));
}

TEST(StrictToml, NumbersMustBeFiniteAndInRange) {
  StrictTable t = StrictTable::parse("a = nan\nb = inf\nc = 0\nd = -1\ne = [1, nan]\n", "t.toml");
  EXPECT_THAT(complaint([&] { t.angle("a"); }), HasSubstr("finite"));
  EXPECT_THAT(complaint([&] { t.number("b"); }), HasSubstr("finite"));
  EXPECT_THAT(complaint([&] { t.positive("c"); }), HasSubstr("greater than 0"));
  EXPECT_THAT(complaint([&] { t.not_negative("d"); }), HasSubstr("0 or more"));
  EXPECT_THAT(complaint([&] { t.numbers("e", 2); }), HasSubstr("2 numbers"));
}

TEST(StrictToml, AChoiceListsItsWords) {
  StrictTable t = StrictTable::parse("start = \"circlin\"\n", "t.toml");
  const std::string text = complaint([&] { t.choice("start", {"rest", "circling", "steady"}); });
  EXPECT_THAT(text, HasSubstr("rest, circling, steady"));
  EXPECT_THAT(text, HasSubstr("did you mean \"circling\""));
}

TEST(StrictToml, NearestWordIsNearOrNothing) {
  EXPECT_EQ(nearest_word("phase_lag", {"phi_rad", "phase_lag_rad"}), "phase_lag_rad");
  EXPECT_EQ(nearest_word("zzzz", {"phi_rad", "mu1"}), "");
}

TEST(StrictToml, AnObjectStandsInPlaceOfAFile) {
  StrictTable t = StrictTable::of(Json::parse(R"({"phi_rad": "pi/2", "cycles": 20, "fit": {"mu1": 0.5},
      "on": true, "disc": [1, 2.5, 3], "run": [{"a": 1}, {"a": "b"}]})"),
                                  "campaign");
  EXPECT_DOUBLE_EQ(*t.angle("phi_rad"), std::numbers::pi / 2);
  EXPECT_EQ(*t.integer("cycles"), 20);
  EXPECT_EQ(*t.boolean("on"), true);
  EXPECT_EQ(*t.numbers("disc", 3), (std::vector<double>{1, 2.5, 3}));
  StrictTable fit = *t.table("fit");
  EXPECT_EQ(*fit.number("mu1"), 0.5);
  EXPECT_EQ(complaint([&] { fit.integer("mu1"); }),
            "campaign: `mu1` in [fit] must be a whole number, not 0.5");
  std::vector<StrictTable> runs = t.tables("run");
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(complaint([&] { runs[1].number("a"); }),
            "campaign, run 2: `a` in [[run]] must be a number, not the text \"b\"");
}

TEST(StrictToml, AnObjectHoldsWhatAFileCould) {
  EXPECT_EQ(complaint([] { StrictTable::of(Json::parse(R"({"a": [1, null]})"), "c"); }),
            "c: `a` must be a number, a text, a list or a table");
  std::string deep = "1";
  for (int k = 0; k < 40; ++k) deep = "[" + deep + "]";
  EXPECT_EQ(complaint([&] { StrictTable::of(Json::parse("{\"a\": " + deep + "}"), "c"); }),
            "c: `a` is nested too deeply");
}

}  // namespace
}  // namespace tribotrack::apps
