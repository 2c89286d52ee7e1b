#include "apps/text/toml/key_depth.h"

#include <gmock/gmock.h>

#include "apps/program.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
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

TEST(KeyDepth, ValuesInValuesAreRefusedByTheParser) {
  for (const char* open : {"[", "{a="})
    EXPECT_NE(complaint("x = " +
                        [&] {
                          std::string text;
                          for (int k = 0; k < 100000; ++k) text += open;
                          return text;
                        }()),
              "no complaint");
}

TEST(KeyDepth, WhatPeopleWriteIsRead) {
  EXPECT_EQ(complaint("fit.prior.mu1 = { mean = 0.1, sd = 0.01 }\nlist = [1.5, 2.5, 3.5]\n"), "no complaint");
  EXPECT_EQ(complaint("# wait ........................................................ done\n"),
            "no complaint");
  std::string numbers = "x = [0.5";
  for (int k = 0; k < 1000; ++k) numbers += ", 0.5";
  EXPECT_EQ(complaint(numbers + "]"), "no complaint");
}

}  // namespace
}  // namespace tribotrack::apps
