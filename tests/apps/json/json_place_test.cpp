#include "apps/json/json_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace tribotrack::apps {
namespace {

const Json kJson =
    Json::parse(R"({"n": 2.5, "k": 20, "r": 20.0, "big": 18446744073709551615, "long": 3000000000,
  "huge": 1e300, "t": "word", "b": true, "nothing": null, "l": [1, "two"], "o": {"inner": [{"x": "y"}]}})");

std::string refusal(const std::function<void(const JsonPlace&)>& read) {
  try {
    read({kJson, ""});
  } catch (const WrongContent& error) {
    return error.what();
  }
  return "accepted";
}

TEST(JsonPlace, ValuesComeByTheirKind) {
  const JsonPlace json{kJson, ""};
  EXPECT_EQ(json.at("n").number(), 2.5);
  EXPECT_EQ(json.at("k").integer(), 20);
  EXPECT_EQ(json.at("r").whole(), 20);
  EXPECT_EQ(json.at("long").whole(), 3000000000);
  EXPECT_EQ(json.at("t").text(), "word");
  EXPECT_TRUE(json.at("b").boolean());
  EXPECT_TRUE(std::isnan(json.at("nothing").number_or_null()));
  EXPECT_EQ(json.at("l").items().size(), 2u);
}

TEST(JsonPlace, WhatIsNotThereIsWhatTheCallerTakesInstead) {
  const JsonPlace json{kJson, ""};
  EXPECT_EQ(json.number("none", 7), 7);
  EXPECT_EQ(json.number("nothing", 7), 7) << "null";
  EXPECT_EQ(json.whole("none", 7), 7);
  EXPECT_EQ(json.integer("k", 7), 20);
  EXPECT_EQ(json.boolean("none", true), true);
  EXPECT_EQ(json.text("none"), "");
  EXPECT_TRUE(json.items("none").empty());
  EXPECT_FALSE(json.find("nothing"));
}

TEST(JsonPlace, WhatIsOfAnotherKindIsRefusedByItsPlace) {
  EXPECT_EQ(refusal([](auto& j) { j.at("none"); }), "`none` is missing");
  EXPECT_EQ(refusal([](auto& j) { j.at("l").at(1).number(); }), "`l[1]` must be a number, not \"two\"");
  EXPECT_EQ(refusal([](auto& j) { j.at("o").at("inner").at(0).at("x").boolean(); }),
            "`o.inner[0].x` must be true or false, not \"y\"");
  EXPECT_EQ(refusal([](auto& j) { j.at("n").whole(); }), "`n` must be a whole number, not 2.5");
  EXPECT_EQ(refusal([](auto& j) { j.at("huge").whole(); }), "`huge` must be a whole number, not 1e+300");
  EXPECT_NE(refusal([](auto& j) { j.at("big").whole(); }), "accepted");
  EXPECT_NE(refusal([](auto& j) { j.at("long").integer(); }), "accepted");
  EXPECT_EQ(refusal([](auto& j) { j.number("t", 7); }), "`t` must be a number, not \"word\"");
  EXPECT_EQ(refusal([](auto& j) { j.at("t").find("x"); }), "`t` must be an object, not \"word\"");
  EXPECT_EQ(refusal([](auto& j) { j.items("k"); }), "`k` must be a list, not 20");
  EXPECT_EQ(refusal([](auto& j) { j.texts("l"); }), "`l[0]` must be a text, not 1");
  EXPECT_EQ(refusal([](auto& j) { j.at("l").at(5); }), "`l[5]` is missing");
}

}  // namespace
}  // namespace tribotrack::apps
