#include "apps/program/streams.h"

#include <gmock/gmock.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class Streams : public ProgramTest {};

TEST_F(Streams, AFullStandardOutputIsAnError) {
  for (const char* command :
       {"simulate", "simulate --json", "simulate -o -", "--version", "--help", "track --help", "init new"}) {
    const Outcome outcome = run(std::string(command) + " >/dev/full");
    EXPECT_EQ(outcome.exit_code, 1) << command;
    EXPECT_THAT(outcome.err, HasSubstr("write error")) << command;
  }
  EXPECT_THAT(run("simulate >/dev/full -q").err, HasSubstr("No space left on device"));
}

TEST_F(Streams, AClosedStandardOutputIsAnError) {
  const Outcome outcome = run("simulate -q >&-");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("write error"));
}

TEST_F(Streams, AClosedStandardErrorIsIgnored) {
  EXPECT_EQ(run("simulate -o t.csv 2>&-").exit_code, 0);
  EXPECT_EQ(content_of(in_folder("t.csv")).substr(0, 7), "time_s,");
  EXPECT_EQ(run("probe none 2>&-").exit_code, 3);
  EXPECT_EQ(run("no-such-command 2>&-").exit_code, 2);
  EXPECT_EQ(run("simulate --mu1 x 2>/dev/full").exit_code, 2);
}

}  // namespace
}  // namespace tribotrack::apps
