#include "apps/program/streams.h"

#include <gmock/gmock.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class Streams : public ProgramTest {
 protected:
  /// With redirections of one's own; `err` is what went to err.txt.
  Outcome redirected(const std::string& command) const {
    run(command + "; echo $? >code; :");
    return {std::stoi(content_of(folder_ / "code")), "", content_of(folder_ / "err.txt")};
  }
};

TEST_F(Streams, AFullStandardOutputIsAnError) {
  for (const char* command : {"simulate -q", "simulate -q --json", "simulate -q -o -", "--version", "--help",
                              "track --help", "init new"}) {
    const Outcome outcome = redirected(std::string(command) + " >/dev/full 2>err.txt");
    EXPECT_EQ(outcome.exit_code, 1) << command;
    EXPECT_THAT(outcome.err, HasSubstr("tribotrack: write error: ")) << command;
  }
  EXPECT_THAT(redirected("simulate -q >/dev/full 2>err.txt").err, HasSubstr("No space left on device"));
}

TEST_F(Streams, AClosedStandardOutputIsAnError) {
  const Outcome outcome = redirected("simulate -q >&- 2>err.txt");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("write error"));
}

TEST_F(Streams, WhatAFileHoldsDoesNotControlTheTerminal) {
  put(in_folder("t.csv"), "frame,\x1b]0;gone\x07\x1b[2J\n1,2\n");
  put(in_folder("c.toml"), "[camera]\nmarker = \"\\u001b[2J\"\n");
  for (const char* command : {"measure t.csv", "fit c.toml -o f.json"}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos) << command;
  }
  EXPECT_NE(run("fit c.toml -o f.json").err.find("?[2J"), std::string::npos);
}

TEST_F(Streams, AStandardErrorThatTakesNothingIsIgnored) {
  for (const char* error : {"2>&-", "2>/dev/full"}) {
    EXPECT_EQ(redirected(std::string("simulate -o t.csv >out.txt ") + error).exit_code, 0);
    EXPECT_EQ(content_of(in_folder("t.csv")).substr(0, 7), "time_s,");
    EXPECT_EQ(redirected(std::string("probe none ") + error).exit_code, 3);
    EXPECT_EQ(redirected(std::string("no-such-command ") + error).exit_code, 2);
    EXPECT_EQ(redirected(std::string("simulate --mu1 x ") + error).exit_code, 2);
  }
}

}  // namespace
}  // namespace tribotrack::apps
