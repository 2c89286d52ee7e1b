// What is no JSON is answered with file, line, column and what stands there, never in a library's words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "apps/program.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class JsonFiles : public ProgramTest {
 protected:
  std::string complaint(const std::string& text) {
    put(in_folder("a.json"), text);
    std::string said = complaint_of([&] { read_json(in_folder("a.json")); });
    EXPECT_THAT(said, Not(HasSubstr("exception")));
    EXPECT_THAT(said, Not(HasSubstr("parse_error")));
    const std::string folder = in_folder("").string();
    return said.starts_with(folder) ? said.substr(folder.size()) : said;
  }
};

TEST_F(JsonFiles, WhatIsJsonIsRead) {
  EXPECT_EQ(complaint("{\"a\": [1, 2.5e-3, null, true, \"\\u00e4 [{ \\\" \"]}\n"), "no complaint");
  EXPECT_EQ(complaint("\xEF\xBB\xBF[]"), "no complaint") << "a byte order mark";
}

TEST_F(JsonFiles, MistakesHaveTheirPlace) {
  EXPECT_THAT(complaint("{\n  \"a\": NaN\n}"), StartsWith("a.json:2:8: is no JSON: "));
  EXPECT_THAT(complaint("{\n\"a\": 1e999}"), AllOf(StartsWith("a.json: is no JSON"), HasSubstr("1e999")));
  EXPECT_THAT(complaint("{\"a\": 1,\n\"b\": [1, 2"), StartsWith("a.json:2:11"));
  for (const std::string text :
       {"", "{", "[1 2]", "\x01", "\"", "{\"a\"}", "tru", "{]", "[\"\xE4\"]", "{} {}"})
    EXPECT_THAT(complaint(text), AllOf(StartsWith("a.json:1:"), HasSubstr("correct it"))) << text;
}

TEST_F(JsonFiles, DepthAndNamesAreLimited) {
  EXPECT_THAT(complaint(std::string(200000, '[') + std::string(200000, ']')),
              HasSubstr("deeper than 64 levels"));
  std::string objects;
  for (int k = 0; k < 200000; ++k) objects += "{\"a\":";
  EXPECT_THAT(complaint(objects), HasSubstr("deeper than 64"));
  EXPECT_EQ(complaint(std::string(64, '[') + std::string(64, ']')), "no complaint");
  std::string names = "{\"\": 0";
  for (int k = 0; k < 10000; ++k) names += ", \"" + std::to_string(k) + "\": 0";
  EXPECT_THAT(complaint(names + "}"), HasSubstr("more than 10000 names"));
}

const Json kJson =
    Json::parse(R"({"n": 2.5, "k": 20, "r": 20.0, "big": 18446744073709551615, "long": 3000000000,
  "huge": 1e300, "t": "word", "b": true, "nothing": null, "l": [1, "two"], "o": {"inner": [{"x": "y"}]}})");

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

}  // namespace

}  // namespace tribotrack::apps
