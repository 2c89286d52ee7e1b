// One scene of known truth through containers, clocks and damages: w and phase as they were, within three
// standard deviations, or a refusal that names the cause.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>

#include "apps/measuring/measure_track.h"
#include "apps/program.h"
#include "apps/recording/check.h"
#include "apps/recording/record.h"
#include "apps/recording/track.h"
#include "vision/analytic_scene.h"
#include "vision/frame_sink.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using vision::Picture;

constexpr double kRate = 240, kW = 62.8, kPhase = 0.7, kAmplitude = 4;
constexpr int kFrames = 100, kWidth = 112, kHeight = 80;

/// Part and mark go round together, at frame k of kRate.
Picture picture_at(double k) {
  std::mt19937 random(static_cast<unsigned>(7 + 2 * k));
  const double phase = kW * k / kRate + kPhase;
  const double dx = kAmplitude * std::cos(phase), dy = kAmplitude * std::sin(phase);
  vision::test::TestScene scene;
  scene.width = kWidth;
  scene.height = kHeight;
  scene.discs = {{.x = 72 + dx, .y = 40 + dy, .radius = 15}, {.x = 26 + dx, .y = 30 + dy, .radius = 8}};
  return vision::test::noisy(scene.render(), 1, random);
}

const std::vector<Picture>& pictures() {
  static const std::vector<Picture> all = [] {
    std::vector<Picture> rendered;
    for (int k = 0; k < kFrames; ++k) rendered.push_back(picture_at(k));
    return rendered;
  }();
  return all;
}

class ClockTruth : public ProgramTest {
 protected:
  void write(const std::string& name, double rate, const std::vector<Picture>& frames = pictures(),
             int crf = 12) {
    const auto sink = vision::create_sink(
        in_folder(name), {.width = kWidth, .height = kHeight, .frame_rate_hz = rate, .crf = crf});
    for (const Picture& frame : frames) sink->write(frame);
    sink->close();
  }
  /// "" where w and phase are right, else what is wrong.
  std::string wrong(const std::string& name, std::optional<double> fps = {},
                    std::optional<std::int64_t> step = {}) {
    TrackChoices choices;
    Json& camera = choices.keys["camera"];
    if (fps) camera["frame_rate_hz"] = *fps;
    camera["mm_per_px"] = 0.1;
    const double x = kAmplitude * std::cos(kPhase), y = kAmplitude * std::sin(kPhase);
    camera["disc_px"] = {72 + x, 40 + y, 15};
    camera["marker_px"] = {26 + x, 30 + y, 8};
    choices.frame_step = step;
    try {
      const Recording recording = tracked(checked(recording_of(in_folder(name), choices)), std::nullopt);
      json_ = measure_track(name, track_in(recording), {}).json;
    } catch (const std::exception& refusal) {
      return refusal.what();
    }
    std::string text;
    for (const auto& [key, truth] :
         {std::pair{"angular_frequency_rad_s", kW}, std::pair{"phase_at_zero_rad", kPhase}}) {
      const double value = json_.at(key), sd = json_.at(std::string(key) + "_sd");
      if (!(std::abs(value - truth) <= 3 * sd))
        text += fmt::format("{} {} +- {}, truth {}; ", key, value, sd, truth);
    }
    return text;
  }
  bool ffmpeg(const std::string& arguments) {
    return std::system(("cd " + in_folder("").string() + " && ffmpeg -v error -y " + arguments).c_str()) == 0;
  }

  Json json_;
};

TEST_F(ClockTruth, FormatsThatStateTheRateOfRecording) {
  for (const char* name : {"a.cine", "a.mkv", "a.avi", "a.mp4"}) {
    write(name, kRate);
    EXPECT_EQ(wrong(name), "") << name;
  }
}

TEST_F(ClockTruth, PicturesAndBarePixels) {
  std::filesystem::create_directory(in_folder("shot"));
  write("shot/f%03d.png", kRate);
  EXPECT_THAT(wrong("shot"), HasSubstr("--fps"));
  EXPECT_EQ(wrong("shot", kRate), "");
  put(in_folder("shot/f.cih"), "Record Rate(fps) : 960\nSave Step : 4\n");
  EXPECT_EQ(wrong("shot"), "");
  put(in_folder("a.cih"),
      fmt::format("Record Rate(fps) : {}\nTotal Frame : {}\nImage Width : {}\nImage Height : "
                  "{}\nColor Bit : 8\nEffectiveBit Depth : 8\nEffectiveBit Side : Lower\n",
                  kRate, kFrames, kWidth, kHeight));
  std::string bare;
  for (const Picture& picture : pictures())
    for (const float level : picture.levels()) bare += static_cast<char>(static_cast<unsigned char>(level));
  put(in_folder("a.mraw"), bare);
  EXPECT_EQ(wrong("a.mraw"), "");
  EXPECT_EQ(wrong("a.mraw", {}, 3), "") << "every third frame";
  std::filesystem::remove(in_folder("shot/f070.png"));
  EXPECT_THAT(wrong("shot", kRate), HasSubstr("missing"));
}

TEST_F(ClockTruth, PicturesStoredTwice) {
  std::vector<Picture> twice;
  for (const Picture& picture : pictures()) twice.insert(twice.end(), 2, picture);
  for (const auto& [name, crf] : {std::pair{"a.mkv", 0}, std::pair{"a.mp4", 20}}) {
    write(name, 2 * kRate, twice, crf);
    EXPECT_EQ(wrong(name), "") << name;
    EXPECT_EQ(json_.at("frames_repeated"), kFrames) << name;
  }
}

/// Without --fps, and where ticks do not fix the rate with it.
struct DropCase {
  const char *form, *name;
  std::optional<double> fps;
};

class FramesDropped : public ClockTruth, public ::testing::WithParamInterface<DropCase> {};

TEST_P(FramesDropped, LeaveTheOthersTheirTimes) {
  write("f%03d.png", kRate);
  if (!ffmpeg("-version > /dev/null 2>&1")) GTEST_SKIP() << "no ffmpeg to write such videos with";
  const auto& [form, name, fps] = GetParam();
  ASSERT_TRUE(
      ffmpeg(std::string("-framerate 240 -i f%03d.png -vf \"select='not(between(n,40,42)+eq(n,97))'\" ") +
             "-vsync passthrough " + form + " " + name));
  EXPECT_EQ(wrong(name, fps), "");
  EXPECT_EQ(json_.at("frames_missing"), 4);
  if (std::string(name) != "c.avi") return;
  // Slowed for playback: the stamps' gaps stay under the rate given.
  ASSERT_TRUE(ffmpeg("-itsscale 8 -i c.avi -c copy e.mov"));
  EXPECT_EQ(wrong("e.mov", kRate), "");
}

INSTANTIATE_TEST_SUITE_P(
    Clocks, FramesDropped,
    ::testing::Values(DropCase{"-c:v libx264 -qp 8 -video_track_timescale 2400", "a.mov", {}},
                      DropCase{"-c:v libx264 -qp 8 -video_track_timescale 600", "b.mov", kRate},
                      DropCase{"-c:v mjpeg -q:v 2", "c.avi", {}}, DropCase{"-c:v ffv1", "d.mkv", kRate}));

TEST_F(ClockTruth, WhatWouldBeWrongIsRefusedByItsCause) {
  std::vector<Picture> weaved;
  for (int k = 0; k + 1 < 80; k += 2) {
    weaved.push_back(pictures()[static_cast<std::size_t>(k)]);
    const Picture& later = pictures()[static_cast<std::size_t>(k) + 1];
    for (int y = 1; y < kHeight; y += 2) std::ranges::copy(later.row(y), weaved.back().row(y).begin());
  }
  write("weaved.mkv", kRate / 2, weaved);
  EXPECT_THAT(wrong("weaved.mkv"), HasSubstr("interlaced"));
  write("f%03d.png", kRate);
  if (!ffmpeg("-version > /dev/null 2>&1")) GTEST_SKIP() << "no ffmpeg to write such videos with";
  ASSERT_TRUE(ffmpeg("-framerate 240 -i f%03d.png -vf setsar=4/3 -c:v ffv1 wide.mkv"));
  EXPECT_THAT(wrong("wide.mkv"), HasSubstr("not square"));
}

}  // namespace
}  // namespace tribotrack::apps
