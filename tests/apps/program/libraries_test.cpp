// What the dynamic linker loads for a command.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Libraries : public ProgramTest {};

TEST_F(Libraries, OfPictureFilesAreNotLoadedForACommandWithout) {
  const Outcome outcome = run("--version", "LD_DEBUG=files ");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("libopencv_core.so"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("libgdal")));
}

}  // namespace
}  // namespace tribotrack::apps
