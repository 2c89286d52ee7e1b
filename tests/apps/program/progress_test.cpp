// Progress says how far the work is, how fast, and how long it still takes.
#include <gmock/gmock.h>

#include "apps/program.h"
#include "apps/program/progress.h"

namespace tribotrack::apps {
namespace {

class Streams : public ProgramTest {};

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

TEST_F(Streams, ProgressForAProgramIsALineOfJson) {
  const Outcome outcome = run("sweep --over phi_rad=0:6:4 -o s.csv", "TRIBOTRACK_PROGRESS=json ");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("{\"progress\":\"sweep: "), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace tribotrack::apps
