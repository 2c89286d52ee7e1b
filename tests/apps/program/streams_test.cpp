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

}  // namespace
}  // namespace tribotrack::apps
