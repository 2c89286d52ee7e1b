// Several recordings at once, of different length, some of them done long ago.
#include "apps/program/runs_progress.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <cstdlib>
#include <functional>

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

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

TEST(RunsProgress, WhatWasCurrentTellsNothingOfTheTimeLeft) {
  const std::string line = last_line({1000, 300, 100}, [](RunsProgress& progress) {
    for (int k = 0; k < 3; ++k) progress.finish(0);
  });
  EXPECT_THAT(line, HasSubstr("(0 %)"));
  EXPECT_THAT(line, Not(HasSubstr("left")));
}

}  // namespace
}  // namespace tribotrack::apps
