// One scene of known truth through containers, clocks and damages: w and phase as they were, within three
// standard deviations.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>

#include "apps/measuring/measure_track.h"
#include "apps/program.h"
#include "apps/recording/recording.h"
#include "apps/recording/track.h"
#include "vision/analytic_scene.h"
#include "vision/frame_sink.h"

namespace tribotrack::apps {
namespace {

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
  void write(const std::string& name) {
    const auto sink = vision::create_sink(
        in_folder(name), {.width = kWidth, .height = kHeight, .frame_rate_hz = kRate, .crf = 12});
    for (const Picture& frame : pictures()) sink->write(frame);
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
    write(name);
    EXPECT_EQ(wrong(name), "") << name;
  }
  EXPECT_EQ(wrong("a.cine", {}, 3), "") << "every third frame";
}

/// Without --fps, and where ticks do not fix the rate with it.
struct DropCase {
  const char *form, *name;
  std::optional<double> fps;
};

class FramesDropped : public ClockTruth, public ::testing::WithParamInterface<DropCase> {};

TEST_P(FramesDropped, LeaveTheOthersTheirTimes) {
  write("f%03d.png");
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

}  // namespace
}  // namespace tribotrack::apps
