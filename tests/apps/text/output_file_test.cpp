#include "apps/text/output_file.h"

#include <gmock/gmock.h>

#include "apps/program.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

using ::testing::ElementsAre;

class OutputFile : public ProgramTest {};

TEST_F(OutputFile, WhatCannotBeWrittenIsSaidBeforeTheWork) {
  EXPECT_THROW(require_writable(in_folder("nowhere/a.csv")), InvalidInput);
  EXPECT_THROW(require_writable(folder_), InvalidInput);
  put(in_folder("file"), "in the way");
  EXPECT_THROW(create_folder(in_folder("file/below")), InvalidInput);
  require_writable(in_folder("a.csv"));
  EXPECT_THAT(left_behind(), ElementsAre("file"));
}

TEST_F(OutputFile, ASignalLeavesNoHalfWrittenFile) {
  // A long render, ended from outside: neither the recording nor a piece of it may remain.
  put(in_folder("scene.toml"), "[video]\nwidth = 640\nheight = 480\nframes = 100000\n");
  const std::string command =
      "cd '" + folder_.string() +
      "' && { '" TRIBOTRACK_BINARY
      "' synth scene.toml -o v.cine -q & "
      "p=$!; for i in $(seq 300); do ls -a | grep -q partial && break; sleep 0.1; done; "
      "ls -a | grep -c partial >seen; kill -TERM $p; wait $p; echo $? >code; }";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_NE(content_of(in_folder("seen")), "0\n")
      << "the file was never being written: this test shows nothing";
  EXPECT_EQ(content_of(in_folder("code")), "143\n");
  std::filesystem::remove(in_folder("seen"));
  std::filesystem::remove(in_folder("code"));
  EXPECT_THAT(left_behind(), ElementsAre("scene.toml"));
}

}  // namespace
}  // namespace tribotrack::apps
