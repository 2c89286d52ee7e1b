#include "apps/text/toml/slips.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

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

TEST(TomlSlips, ABinaryFileIsNamedForWhatItIs) {
  using namespace std::string_literals;
  for (const std::string& recording :
       {"CI,\0"s, "\0\0\0 ftypisom"s, "RIFF\0\0\0\0AVI "s, "\x1a\x45\xdf\xa3\0"s})
    EXPECT_THAT(encoding_slip(recording), HasSubstr("is a recording"));
  EXPECT_THAT(encoding_slip("PK\x03\x04\0\0"s), HasSubstr("no text file"));
}

TEST(TomlSlips, WhatIsWrongWithALine) {
  for (const auto& [line, words] : std::vector<std::pair<std::string, std::string>>{
           {"a = 0,28", "decimal point, 0.28"},
           {"a = -1,5  # comment", "decimal point, -1.5"},
           {"video = \"rec/a.cine", "closing quote"},
           {"video = 'rec/a.cine", "closing quote"},
           {"a = 0.28 mm", "`mm` stands behind the number"},
           {"f = 1e3Hz", "`Hz` stands behind the number"},
           {"video = rec/a.cine", "a text stands in quotes, \"rec/a.cine\""},
           {"a =", "`a` has no value"},
           {"[platform", "bracket"},
           {"marker_px = [1, 2, 3", "bracket"},
           {"mu1 = { mean = 0.1, sd = 0.01", "brace"},
           {"video = \"C:\\rec\\a.cine\"", "backslash"},
           {"amplitude 0.28", "KEY = VALUE"},
           {"a = 1 = 2", "cannot be read"}})
    EXPECT_THAT(toml_slip("# first\n" + line + "\r\nb = 1\n", 2, 1, "library words"), HasSubstr(words))
        << line;
  EXPECT_THAT(toml_slip("a = 1\na = 2", 2, 1, "cannot redefine existing integer 'a'"),
              HasSubstr("`a` is given twice"));
}

TEST(TomlSlips, ALineOfAnyLengthAndAnyPlaceAreTaken) {
  EXPECT_FALSE(toml_slip("a = " + std::string(1'000'000, 'x'), 1, 5, "").empty());
  EXPECT_FALSE(toml_slip("a = 1", 17, 1, "").empty());
  EXPECT_FALSE(toml_slip("", 0, 0, "redefine").empty());
}

}  // namespace
}  // namespace tribotrack::apps
