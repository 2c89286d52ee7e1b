#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "apps/program.h"
#include "apps/program/errors.h"
#include "apps/text/input_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

using ::testing::HasSubstr;

TEST(StrictToml, NumbersAreThereAsTheyWereWritten) {
  StrictTable table = StrictTable::parse(
      "# \u00e9\r\na = 0.280 # 0.28\nb = { \"\u00e9\" = 2.50e-3, c = -1_0.5 }\nd = \"45.0deg\"\ne = 7\nf = "
      "[1.0]\n",
      "c.toml");
  EXPECT_EQ(table.written("a"), "0.280");
  EXPECT_EQ(table.table("b")->written("c"), "-1_0.5");
  EXPECT_EQ(table.table("b")->written("\u00e9"), "2.50e-3");
  EXPECT_EQ(table.written("d"), "45.0deg");
  EXPECT_EQ(table.written("e"), "7");
  EXPECT_EQ(table.written("f"), "");
  EXPECT_EQ(table.written("g"), "");
  EXPECT_EQ(StrictTable::of({{"a", 0.280}}, "object").written("a"), "0.28");
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
  EXPECT_EQ(complaint_of([&] { fit.integer("mu1"); }),
            "campaign: `mu1` in [fit] must be a whole number, not 0.5");
  std::vector<StrictTable> runs = t.tables("run");
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(complaint_of([&] { runs[1].number("a"); }),
            "campaign, run 2: `a` in [[run]] must be a number, not the text \"b\"");
}

TEST(StrictToml, AnObjectHoldsWhatAFileCould) {
  EXPECT_EQ(complaint_of([] { StrictTable::of(Json::parse(R"({"a": [1, null]})"), "c"); }),
            "c: `a` must be a number, a text, a list or a table");
  std::string deep = "1";
  for (int k = 0; k < 40; ++k) deep = "[" + deep + "]";
  EXPECT_EQ(complaint_of([&] { StrictTable::of(Json::parse("{\"a\": " + deep + "}"), "c"); }),
            "c: `a` is nested too deeply");
}

TEST(TomlSlips, AnEncodingIsNamedWithThePlaceThatShowsIt) {
  EXPECT_EQ(encoding_slip("a = 1 # \u00b5m, \u4e2d, \U0001f600\n"), "");
  EXPECT_EQ(encoding_slip("\xef\xbb\xbf"
                          "a = 1\n"),
            "");
  EXPECT_THAT(encoding_slip("a = 1\n# Gr\xf6\xdf"
                            "e\n"),
              testing::StartsWith(":2:5: "));
  EXPECT_THAT(encoding_slip("# \u00e4 \xe4\n"), testing::StartsWith(":1:5: "));  // columns are characters
  EXPECT_THAT(encoding_slip("\xc0\xaf"), HasSubstr("UTF-8"));                    // overlong
  EXPECT_THAT(encoding_slip("\xe2\x82"), HasSubstr("UTF-8"));                    // cut short
  for (const std::string_view bom : {"\xff\xfe", "\xfe\xff"})
    EXPECT_THAT(encoding_slip(bom), HasSubstr("UTF-16"));
}

TEST(TomlSlips, ALineIsRepeatedWithWhatMayStandThere) {
  EXPECT_EQ(toml_slip("# first\na = 0,28\r\nb = 1\n", 2, 6, "library words").substr(0, 47),
            "`a = 0,28` cannot be read from column 6 on: wri");
  EXPECT_EQ(toml_slip("a = 1\na = 2", 2, 1, "cannot redefine existing integer 'a' as integer"),
            "`a` is given twice; take one of them out");
}

TEST(TomlSlips, ALineOfAnyLengthAndAnyPlaceAreTaken) {
  EXPECT_FALSE(toml_slip("a = " + std::string(1'000'000, 'x'), 1, 5, "").empty());
  EXPECT_FALSE(toml_slip("a = 1", 17, 1, "").empty());
  EXPECT_FALSE(toml_slip("", 0, 0, "redefine").empty());
}

using testing::StartsWith;

std::string dotted(const std::string& part, int parts) {
  std::string key = part;
  for (int k = 1; k < parts; ++k) key += "." + part;
  return key;
}

std::string complaint(const std::string& text) {
  return complaint_of([&] { StrictTable::parse(text, "c.toml"); });
}

TEST(KeyDepth, ThousandsOfTablesInTablesAreRefused) {
  for (const char* part : {"a", "\"a b\"", "'a'", "a "}) {
    EXPECT_THAT(complaint(dotted(part, 200000) + " = 1"),
                StartsWith("c.toml:1:1: a key of more than 32 parts"));
    EXPECT_THAT(complaint("x = 1\n[" + dotted(part, 200000) + "]"), StartsWith("c.toml:2:2: a key of more"));
    EXPECT_THAT(complaint("x = { " + dotted(part, 200000) + " = 1 }"), StartsWith("c.toml:1:6"));
  }
}

TEST(KeyDepth, WhatPeopleWriteIsRead) {
  EXPECT_EQ(complaint("fit.prior.mu1 = { mean = 0.1, sd = 0.01 }\nlist = [1.5, 2.5, 3.5]\n"), "no complaint");
  EXPECT_EQ(complaint("# wait ........................................................ done\n"),
            "no complaint");
  std::string numbers = "x = [0.5";
  for (int k = 0; k < 1000; ++k) numbers += ", 0.5";
  EXPECT_EQ(complaint(numbers + "]"), "no complaint");
}

TEST(TomlText, ReadsBackAsItWas) {
  for (const std::string text :
       {"a \"b\" \\ c", "line\n[[run]]\nvideo = \"x\"", "\x1b[2J\x07\x7f", "\xc3\xbc\xce\xa9"})
    EXPECT_EQ(StrictTable::parse("x = " + toml_text(text), "c.toml").text("x"), text);
  EXPECT_THAT(complaint_of([] { toml_text("f\xfcr"); }), testing::HasSubstr("rename it"));
  EXPECT_EQ(toml_comment("f\xfcr\n[[run]] \x1b"), "f?r [[run]] ?");
}

TEST(ReadText, WhatMayNeverEndIsRefused) {
  EXPECT_THAT(complaint_of([] { read_text("/dev/zero"); }),
              testing::HasSubstr("/dev/zero: is a fifo or a device"));
  EXPECT_THAT(complaint("x = \"" + std::string(17 << 20, 'a') + "\""),
              testing::HasSubstr("larger than 16 MB"));
}

}  // namespace

}  // namespace tribotrack::apps
