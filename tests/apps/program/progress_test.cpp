// Progress says how far the work is, how fast, and how long it still takes.
#include "apps/program/progress.h"

#include <gmock/gmock.h>

#include <cstdio>

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

TEST(ProgressLine, ElsewhereShortWorkSaysNothing) {
  EXPECT_EQ(shown(ProgressStyle::plain, true), "");
  EXPECT_EQ(shown(ProgressStyle::none, true), "");
}

TEST(ProgressLine, APlainLineHasNoControlCharacters) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* to = ::open_memstream(&text, &size);
  {
    ProgressLine line(ProgressStyle::plain, to);
    line.show("work: 1/2");
  }
  std::fclose(to);
  EXPECT_EQ(std::string(text, size), "work: 1/2\n");
  std::free(text);
}

}  // namespace
}  // namespace tribotrack::apps
