#include "apps/bench/vision/command_shares.h"

#include <gtest/gtest.h>

namespace tribotrack::bench {

namespace {

TEST(CommandShares, SharesAreThoseOfTheTableThatExplainPrints) {
  const CommandShares shares = shares_from(
      "layers: part over platform on   a reason with  two spaces and 12 %\n"
      "time of each stage                     s  share\n"
      "  starting                        0.1000   10 %\n"
      "  hashing the inputs              0.0500    5 %\n"
      "  finding the part                0.0200    2 %\n"
      "  template of the part            0.0300    3 %\n"
      "  first pass: part                0.4000   40 %\n"
      "  rotation by rings               0.2000   20 %\n"
      "  a stage of tomorrow             0.1000   10 %\n"
      "noise 1.04 grey levels\n"
      "  first pass: marker              9.0000   10 %\n",
      2);
  EXPECT_DOUBLE_EQ(shares.starting, 0.05);
  EXPECT_DOUBLE_EQ(shares.hashing, 0.025);
  EXPECT_DOUBLE_EQ(shares.looking, 0.025);
  EXPECT_DOUBLE_EQ(shares.part, 0.2);
  EXPECT_EQ(shares.mark, 0) << "the table was at its end";
  EXPECT_DOUBLE_EQ(shares.rotation, 0.1);
  EXPECT_DOUBLE_EQ(shares.rest, 0.6) << "what nobody names, and the time outside the table";
}

TEST(CommandShares, WithoutATableEverythingIsTheRest) {
  EXPECT_EQ(shares_from("", 1).rest, 1);
}

}  // namespace
}  // namespace tribotrack::bench
