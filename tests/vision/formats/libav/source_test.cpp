#include "vision/formats/libav/source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>

#include "vision/recordings.h"
#include "vision/tracking/gate_lamp.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;

class LibavSourceTest : public RecordingTest {
 protected:
  static SinkOptions options() { return {.width = 48, .height = 32, .frame_rate_hz = 240}; }
};

TEST_F(LibavSourceTest, WhatIsNoVideo) {
  const std::string text = "alpha and v\nare not in here\n";
  write_bytes(file("a.mp4"), FileBytes(text.begin(), text.end()));
  EXPECT_THAT(input_error(file("a.mp4")), AllOf(HasSubstr("a.mp4"), HasSubstr("no video")));
  write_bytes(file("b.txt"), FileBytes(text.begin(), text.end()));
  EXPECT_THAT(input_error(file("b.txt")),
              AllOf(HasSubstr("b.txt"), AnyOf(HasSubstr("no video"), HasSubstr("text"))));
  std::string pages;
  while (pages.size() < 100000) pages += text;
  write_bytes(file("b.txt"), FileBytes(pages.begin(), pages.end()));
  EXPECT_THAT(input_error(file("b.txt")),
              AllOf(HasSubstr("b.txt"), AnyOf(HasSubstr("no video"), HasSubstr("text"))));
  write_bytes(file("b.mp4"), FileBytes(pages.begin(), pages.end()));
  EXPECT_THAT(input_error(file("b.mp4")), AllOf(HasSubstr("b.mp4"), HasSubstr("no video")));
  write_bytes(file("c.mp4"), {});
  EXPECT_THAT(input_error(file("c.mp4")), HasSubstr("empty"));
  EXPECT_THAT(input_error(file("missing.mp4")), HasSubstr("No such file"));
  write_bytes(file("d.mraw"), {1, 2, 3});
  EXPECT_THAT(input_error(file("d.mraw")), HasSubstr("Photron"));
}

TEST_F(LibavSourceTest, TheCamerasSidecarBeatsTheContainer) {
  SinkOptions slow = options();
  slow.frame_rate_hz = 30;
  write_recording(file("a.avi"), slow, 5);
  EXPECT_FALSE(open_source(file("a.avi"))->info().time_base.known());
  const std::string text = "#Camera Information Header\r\nRecord Rate(fps) : 7000\r\nTotal Frame : 5\r\n";
  write_bytes(file("a.cih"), FileBytes(text.begin(), text.end()));
  const auto source = open_source(file("a.avi"));
  EXPECT_EQ(*source->info().time_base.rate_hz, 7000);
  EXPECT_THAT(source->info().time_base.source, HasSubstr("a.cih"));
  EXPECT_EQ(*open_source(file("a.avi"), {.frame_rate_hz = 50.0})->info().time_base.rate_hz, 50);
}

TEST(RealVideos, HeadOnDoesNotKnowItsRate) {
  if (real_data().empty()) GTEST_SKIP() << "TRIBOTRACK_REAL_DATA names no folder";
  const auto path = real_data() / "carrom" / "HeadOn.MP4";
  const auto source = open_source(path);
  EXPECT_EQ(source->info().width, 320);
  EXPECT_EQ(source->info().height, 240);
  EXPECT_EQ(source->info().bits, 8);
  EXPECT_EQ(source->info().frame_count, 752);
  EXPECT_FALSE(source->info().time_base.known());
  EXPECT_THAT(source->info().time_base.why_unknown(), AllOf(HasSubstr("29.97"), HasSubstr("--fps")));
  EXPECT_THAT(source->info().notes, Contains(HasSubstr("limited range")));
  EXPECT_EQ(open_source(path, {.frame_rate_hz = 240.0})->time_s(240), 1);
  expect_exact_random_access(path, 25);
}

}  // namespace
}  // namespace tribotrack::vision
