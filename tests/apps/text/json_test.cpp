// What is no JSON is answered with file, line, column and what stands there, never in a library's words.
#include "apps/text/json.h"

#include <gmock/gmock.h>

#include "apps/program.h"

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

TEST_F(JsonFiles, EveryMistakeHasItsPlaceAndItsName) {
  EXPECT_THAT(complaint("{\n  \"a\": NaN\n}"), StartsWith("a.json:2:8: is no JSON: `NaN`"));
  EXPECT_THAT(complaint("{\"a\": -Infinity}"), HasSubstr("`null` is written"));
  EXPECT_THAT(complaint("{\n\"a\": 1e999}"), StartsWith("a.json:2:6: is no JSON: the number `1e999` is too"));
  EXPECT_THAT(complaint("{\"a\": 1,\n\"b\": [1, 2"),
              AllOf(StartsWith("a.json:2:11"), HasSubstr("in the middle")));
  EXPECT_THAT(complaint("{'a': 1}"), AllOf(StartsWith("a.json:1:2"), HasSubstr("not between '")));
  EXPECT_THAT(complaint("{} // why"), AllOf(StartsWith("a.json:1:4"), HasSubstr("comments")));
  EXPECT_THAT(complaint("[1, 2,]"), AllOf(StartsWith("a.json:1:7"), HasSubstr("`]` does not belong")));
  EXPECT_THAT(complaint("[1, twice]"), AllOf(StartsWith("a.json:1:5"), HasSubstr("`twice`")));
  EXPECT_THAT(complaint("[\"a\nb\"]"), HasSubstr("line end"));
  EXPECT_THAT(complaint("[\"\xE4\"]"), HasSubstr("not UTF-8"));
  EXPECT_THAT(complaint(std::string("\xFF\xFE[\0]\0", 6)), HasSubstr("UTF-16"));
  EXPECT_THAT(complaint(" \n "), HasSubstr("it is empty"));
  EXPECT_THAT(complaint("{} {}"), StartsWith("a.json:1:4"));
  for (const char* text : {"{", "[1 2]", "\x01", "\"", "{\"a\"}", "tru", "{]", "]", "+1", "01"})
    EXPECT_THAT(complaint(text), AllOf(StartsWith("a.json:1:"), HasSubstr("correct it"))) << text;
}

TEST_F(JsonFiles, DepthAndNamesAreLimited) {
  EXPECT_THAT(complaint(std::string(200000, '[') + std::string(200000, ']')),
              StartsWith("a.json:1:65: is no JSON: it nests deeper than 64 levels"));
  std::string objects;
  for (int k = 0; k < 200000; ++k) objects += "{\"a\":";
  EXPECT_THAT(complaint(objects), HasSubstr("deeper than 64"));
  EXPECT_EQ(complaint(std::string(64, '[') + std::string(64, ']')), "no complaint");
  std::string names = "{\"\": 0";
  for (int k = 0; k < 10000; ++k) names += ", \"" + std::to_string(k) + "\": 0";
  EXPECT_THAT(complaint(names + "}"), HasSubstr("more than 10000 names"));
}

}  // namespace
}  // namespace tribotrack::apps
