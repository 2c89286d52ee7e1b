// Progress says how far the work is, how fast, and how long it still takes.
#include <gmock/gmock.h>

#include <cstdio>
#include <cstdlib>
#include <functional>

#include "apps/program.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"

namespace tribotrack::apps {

namespace {

TEST(ProgressText, TellsShareRateAndTimeLeft) {
  EXPECT_EQ(progress_text(4000, 20000, "frames", 5), "4000/20000 (20 %), 800 frames/s, 20 s left");
  EXPECT_EQ(progress_text(3, 12, "scenes", 2), "3/12 (25 %), 1.5 scenes/s, 6 s left");
  EXPECT_EQ(progress_text(3, 12, "", 2), "3/12 (25 %), 6 s left");
  EXPECT_EQ(progress_text(0, 12, "frames", 2), "0/12 (0 %)");
  EXPECT_EQ(progress_text(12, 12, "frames", 0), "12/12 (100 %)");
}

std::string shown(ProgressStyle style, bool last) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* to = ::open_memstream(&text, &size);
  {
    ProgressLine line(style, to);
    for (int k = 0; k < 3; ++k)
      if (line.is_due(last)) line.show("work: 1/2");
  }
  std::fclose(to);
  std::string result(text, size);
  std::free(text);
  return result;
}

TEST(ProgressLine, OnATerminalIsRewrittenAndTakenAway) {
  EXPECT_EQ(shown(ProgressStyle::rewritten, false), "\r\033[Kwork: 1/2\r\033[K");
  EXPECT_EQ(shown(ProgressStyle::rewritten, true),
            "\r\033[Kwork: 1/2\r\033[Kwork: 1/2\r\033[Kwork: 1/2\r\033[K");
}

// Several recordings at once, of different length, some of them done long ago.

using ::testing::HasSubstr;

std::string last_line(const std::vector<std::uintmax_t>& sizes,
                      const std::function<void(RunsProgress&)>& work) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* to = ::open_memstream(&text, &size);
  {
    RunsProgress progress(sizes, ProgressStyle::rewritten, to);
    work(progress);
  }
  std::fclose(to);
  std::string lines(text, size);
  std::free(text);
  const std::string clear = "\r\033[K";
  lines.resize(lines.size() - clear.size());
  return lines.substr(lines.rfind(clear) + clear.size());
}

TEST(RunsProgress, TheShareDoneIsOfTheRecordingsSizes) {
  EXPECT_THAT(last_line({300, 100}, [](RunsProgress& progress) { progress.update(0, 500, 1000); }),
              HasSubstr("runs: 0/2 (37 %), "));
  EXPECT_THAT(last_line({300, 100},
                        [](RunsProgress& progress) {
                          progress.update(0, 500, 1000);
                          progress.update(1, 100, 100);
                          progress.finish(0);
                          progress.finish(1);
                        }),
              HasSubstr("runs: 2/2 (100 %), "));
}

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

}  // namespace

}  // namespace tribotrack::apps
