#include "vision/formats/libav/libav.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <random>
#include <tuple>

#include "vision/recordings.h"
#include "vision/tracking/first_pass.h"

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

/// Frames read in a scattered order are those read one after the other, level by level.
void expect_exact_random_access(const std::filesystem::path& path, int reads) {
  const auto straight = open_source(path);
  const auto scattered = open_source(path);
  const auto count = static_cast<int>(straight->info().frame_count);
  std::vector<Picture> frames;
  for (int k = 0; k < count; ++k) frames.push_back(straight->read(k));
  std::mt19937 random(17);
  for (int i = 0; i < reads; ++i) {
    const int k = static_cast<int>(random() % static_cast<unsigned>(count));
    const Picture frame = scattered->read(k);
    ASSERT_TRUE(std::equal(frame.levels().begin(), frame.levels().end(),
                           frames[static_cast<std::size_t>(k)].levels().begin()))
        << "frame " << k;
  }
}

TEST_F(LibavSourceTest, AnyFrameOfVideosThatStoreFramesOutOfOrder) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "no ffmpeg to write such videos with";
  // In AVI and raw H.264 the stamps do not tell the order; in MP4 and MPEG-TS they do.
  for (const char* name : {"a.mp4", "a.avi", "a.mkv", "a.ts", "a.h264"}) {
    SCOPED_TRACE(name);
    const std::string command =
        "ffmpeg -v error -y -f lavfi -i \"color=black:s=64x48:r=240:d=0.25,"
        "geq=lum='2*N+16':cb=128:cr=128\" -c:v libx264 -bf 3 -g 12 -qp 8 " +
        file(name).string();
    ASSERT_EQ(std::system(command.c_str()), 0);
    const auto source = open_source(file(name));
    ASSERT_EQ(source->info().frame_count, 60);
    for (const int k : {0, 1, 2, 59, 13, 12, 11, 30})
      EXPECT_NEAR(source->read(k).at(20, 20), 2 * k + 16, 0.8) << k;
    expect_exact_random_access(file(name), 40);
  }
}

/// A lamp of 40 x 40 px that is lit at this luma in every second frame, in H.264 of the given range.
void write_lamp(const std::filesystem::path& path, int lit, const std::string& range) {
  const std::string command =
      "ffmpeg -v error -y -f lavfi -i \"color=black:s=96x96:r=240:d=0.05,"
      "geq=lum='if((1-mod(N,2))*lt(abs(X-48),20)*lt(abs(Y-48),20)," +
      std::to_string(lit) + ",60)':cb=128:cr=128\" -c:v libx264 -qp 10 -color_range " + range + " " +
      path.string();
  ASSERT_EQ(std::system(command.c_str()), 0);
}

/// Without a rate given, and where ticks do not fix the rate with it.
TEST_F(LibavSourceTest, LimitedRangeClipsAtWhiteUnlessThereAreLevelsAboveIt) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "no ffmpeg to write such videos with";
  struct Lamp {
    int lit;
    const char* range;
    double clips_at, clipped_share;
  };
  for (const Lamp& lamp : {Lamp{235, "tv", 235, 1}, Lamp{220, "tv", 235, 0}, Lamp{248, "tv", 255, 0},
                           Lamp{235, "pc", 255, 0}, Lamp{255, "pc", 255, 1}}) {
    SCOPED_TRACE(lamp.range + std::to_string(lamp.lit));
    write_lamp(file("a.mp4"), lamp.lit, lamp.range);
    const auto source = open_source(file("a.mp4"));
    EXPECT_EQ(source->info().clipping_level(), lamp.clips_at);
    EXPECT_EQ(GateLamp({48, 48, 12}, *source).sample(*source, 0).clipped_share, lamp.clipped_share);
    if (lamp.lit == 248) {
      EXPECT_THAT(source->info().notes, Contains(HasSubstr("above white")));
    }
  }
}

TEST_F(LibavSourceTest, FramesWhoseStampsTieAreStillApart) {
  // 7 frames to the millisecond of Matroska.
  SinkOptions fast = options();
  fast.frame_rate_hz = 7000;
  write_recording(file("a.mkv"), fast, 50);
  const auto source = open_source(file("a.mkv"));
  ASSERT_EQ(source->info().frame_count, 50);
  for (const int k : {49, 3, 4, 31, 30}) EXPECT_EQ(source->read(k).at(5, 6), test_level(k, 5, 6, 8));
}

TEST_F(LibavSourceTest, AVideoCutShortNeverLosesFramesInSilence) {
  for (const char* name : {"a.mkv", "a.avi", "a.mp4"}) {
    write_recording(file(name), options(), 40);
    const FileBytes whole = read_bytes(file(name));
    ASSERT_EQ(input_error(file(name)), "");
    for (const double share : {0.999, 0.9, 0.5, 0.2, 0.02}) {
      write_bytes(file(name),
                  FileBytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(
                                                               share * static_cast<double>(whole.size()))));
      const std::string error = input_error(file(name));
      if (error.empty())  // what was cut off was no frame
        EXPECT_EQ(open_source(file(name))->info().frame_count, 40) << name << " " << share;
      else
        EXPECT_THAT(error, AllOf(HasSubstr(name), AnyOf(HasSubstr("cut short"), HasSubstr("no video"))))
            << share;
    }
  }
}

TEST_F(LibavSourceTest, AFileThatShrinksWhileReadIsAnError) {
  for (const char* name : {"a.mkv", "a.avi", "a.mp4"}) {
    write_recording(file(name), options(), 400);
    const auto source = open_source(file(name));
    source->read(2);
    std::filesystem::resize_file(file(name), std::filesystem::file_size(file(name)) / 2);
    try {
      for (std::int64_t k = 3; k < 400; ++k) source->read(k);
      FAIL() << name << ": half of the frames are gone";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(name));
    }
  }
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
