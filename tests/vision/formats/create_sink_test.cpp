#include "vision/frame_sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

class FrameSinkTest : public RecordingTest {
 protected:
  /// Largest difference between what was written and what is read, over frames in a scattered order.
  double largest_difference(const std::filesystem::path& path, const SinkOptions& options, int frames) {
    const auto source = open_source(path);
    EXPECT_EQ(source->info().width, options.width);
    EXPECT_EQ(source->info().height, options.height);
    EXPECT_EQ(source->info().frame_count, frames);
    double largest = 0;
    for (int i = 0; i < frames; ++i) {
      const int k = (i * 7 + 3) % frames;  // 7 and `frames` have no common factor in these tests
      const Picture read = source->read(k);
      for (int y = 0; y < options.height; ++y)
        for (int x = 0; x < options.width; ++x)
          largest = std::max(
              largest, std::abs(static_cast<double>(read.at(x, y)) - test_level(k, x, y, options.bits)));
    }
    return largest;
  }
};

TEST_F(FrameSinkTest, LosslessFormsComeBackBitForBit) {
  struct Case {
    const char* name;
    int bits;
    int bits_read;
  };
  const std::vector<Case> cases = {{"a.cine", 8, 8},      {"b.cine", 12, 12},  {"c.mkv", 8, 8},
                                   {"d.mkv", 10, 10},     {"e.mkv", 12, 12},   {"f%03d.png", 8, 8},
                                   {"g%03d.png", 12, 16}, {"h%03d.tif", 8, 8}, {"i%03d.tif", 10, 16}};
  for (const Case& c : cases)
    for (const auto& [width, height] : {std::pair{64, 48}, std::pair{37, 23}}) {
      SCOPED_TRACE(c.name + std::string(" ") + std::to_string(width));
      const SinkOptions options{.width = width, .height = height, .bits = c.bits, .frame_rate_hz = 250};
      write_recording(file(c.name), options, 19);
      EXPECT_EQ(largest_difference(file(c.name), options, 19), 0);
      EXPECT_EQ(open_source(file(c.name))->info().bits, c.bits_read);
    }
}

TEST_F(FrameSinkTest, LossyFormsComeBackClose) {
  // Smooth pictures: noise is what such codings throw away.
  for (const char* name : {"a.avi", "b.mp4"}) {
    const SinkOptions options{.width = 64, .height = 48, .frame_rate_hz = 240, .crf = 10};
    const auto sink = create_sink(file(name), options);
    const auto level = [](int k, int x, int y) { return static_cast<float>(60 + 2 * k + x + y); };
    Picture picture(64, 48);
    for (int k = 0; k < 15; ++k) {
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) picture.at(x, y) = level(k, x, y);
      sink->write(picture);
    }
    sink->close();
    const auto source = open_source(file(name));
    ASSERT_EQ(source->info().frame_count, 15);
    for (const int k : {14, 3, 4, 0, 9}) {
      const Picture read = source->read(k);
      double squares = 0;
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) squares += std::pow(read.at(x, y) - level(k, x, y), 2);
      EXPECT_LT(std::sqrt(squares / (64 * 48)), 1.0) << name << " frame " << k;  // a frame away it is 2
    }
  }
}

TEST_F(FrameSinkTest, CaptureRatesSurviveTheirContainers) {
  for (const char* name : {"a.cine", "a.avi", "a.mp4", "a.mkv"})
    for (const double rate : {100.0, 240.0, 250.0, 1000.0, 7000.0, 100000.0}) {
      write_recording(file(name), {.width = 16, .height = 16, .frame_rate_hz = rate}, 40);
      const auto source = open_source(file(name));
      const TimeBase& base = source->info().time_base;
      if (file(name).extension() == ".avi" && rate >= 1000) {
        EXPECT_FALSE(base.known()) << "AVI says 1000, or 600 beyond it";
        EXPECT_EQ(source->info().frame_count, 40);
        continue;
      }
      ASSERT_TRUE(base.known()) << name << " " << rate << ": " << base.why_unknown();
      EXPECT_NEAR(*base.rate_hz / rate, 1, 1e-6) << name;
      EXPECT_NEAR(source->time_s(39), 39 / rate, 1e-6 / rate + 2e-9) << name;
    }
}

TEST_F(FrameSinkTest, MoreImagesThanTheRoomLeftForTheirTables) {
  const SinkOptions options{.width = 4, .height = 2, .frame_rate_hz = 1e5};
  write_recording(file("a.cine"), options, 5001);
  EXPECT_EQ(largest_difference(file("a.cine"), options, 5001), 0);
}

TEST_F(FrameSinkTest, TheSameFramesGiveTheSameBytes) {
  for (const char* name : {"a.cine", "a.mkv", "a.avi", "a.mp4"}) {
    const SinkOptions options{.width = 32, .height = 32, .frame_rate_hz = 500};
    write_recording(file(name), options, 12);
    const FileBytes first = read_bytes(file(name));
    write_recording(file(name), options, 12);
    EXPECT_EQ(read_bytes(file(name)), first) << name;
  }
}

TEST_F(FrameSinkTest, NothingIsLeftWithoutClose) {
  for (const char* name : {"a.cine", "a.mkv", "a.avi", "a.mp4", "a%d.png", "a%d.tif"}) {
    const auto sink = create_sink(file(name), {.width = 16, .height = 16});
    sink->write(Picture(16, 16, 10));
    sink->write(Picture(16, 16, 20));
  }
  EXPECT_EQ(files_in_folder(), 0u);
}

TEST_F(FrameSinkTest, AnInterruptedProgramLeavesNothing) {
  std::vector<std::unique_ptr<FrameSink>> sinks;
  for (const char* name : {"a.cine", "a.mkv", "a.avi", "a.mp4", "a%02d.png", "a%02d.tif"}) {
    sinks.push_back(create_sink(file(name), {.width = 32, .height = 32}));
    for (int k = 0; k < 9; ++k) sinks.back()->write(test_picture(k, 32, 32, 8));
  }
  EXPECT_GT(files_in_folder(), 0u);
  remove_partial_files();
  EXPECT_EQ(files_in_folder(), 0u);
  sinks.clear();
  EXPECT_EQ(files_in_folder(), 0u);
  write_recording(file("b%02d.png"), {.width = 32, .height = 32}, 3);  // what is finished stays
  remove_partial_files();
  EXPECT_EQ(files_in_folder(), 3u);
}

TEST_F(FrameSinkTest, LevelsAreRoundedAndClipped) {
  const auto sink = create_sink(file("a.cine"), {.width = 8, .height = 1});
  Picture picture(8, 1);
  const std::array<float, 8> written = {-3.0F, 0.4F, 0.6F, 254.4F, 254.6F, 255.4F, 300.0F, std::nanf("")};
  std::copy(written.begin(), written.end(), picture.levels().begin());
  sink->write(picture);
  sink->close();
  const Picture read = open_source(file("a.cine"))->read(0);
  EXPECT_THAT(read.levels(), ::testing::ElementsAre(0, 0, 1, 254, 255, 255, 255, 0));
}

TEST_F(FrameSinkTest, WhatCannotBeWrittenIsRefusedAtOnce) {
  for (const char* name :
       {"missing/a.cine", "missing/a.mkv", "missing/a.avi", "missing/a.mp4", "missing/a%d.png", "a.xyz"})
    EXPECT_THROW(create_sink(file(name), {.width = 8, .height = 8}), InputError) << name;
  EXPECT_THROW(create_sink(file("a.mp4"), {.width = 8, .height = 8, .bits = 12}), InputError);
  EXPECT_THROW(create_sink(file("a.cine"), {.width = 8, .height = 8, .bits = 10}), InputError);
  EXPECT_THROW(create_sink(file("a.cine"), {.width = 0, .height = 8}), InputError);
  EXPECT_THROW(create_sink(file("a.cine"), {.width = 8, .height = 8, .frame_rate_hz = 0}), InputError);
  EXPECT_EQ(files_in_folder(), 0u);
}

}  // namespace
}  // namespace tribotrack::vision
