// What the dynamic linker loads for a command.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Libraries : public ProgramTest {};

TEST_F(Libraries, AreNotLoadedForFilesThatACommandDoesNotTouch) {
  for (const char* command : {"--version", "simulate --cycles 1 --dtau-rad pi/3 -o t.csv"}) {
    const Outcome outcome = run(command, "LD_DEBUG=files ");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_THAT(outcome.err, HasSubstr("libopencv_core.so")) << command;
    for (const char* library : {"libavformat", "libavcodec", "libopencv_imgcodecs", "libgdal"})
      EXPECT_THAT(outcome.err, Not(HasSubstr(library))) << command;
  }
}

TEST_F(Libraries, AreAllThereWhenEverythingIsBoundAtOnce) {
  EXPECT_EQ(run("--version", "LD_BIND_NOW=1 ").exit_code, 0);
}

}  // namespace
}  // namespace tribotrack::apps
