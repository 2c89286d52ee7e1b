#include "apps/recording/track_recording.h"

#include <gmock/gmock.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class TrackRecording : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    put(in_folder("scene.toml"),
        "[platform]\namplitude_mm = 0\n[friction]\nmu1 = 0.2\n[run]\nvelocity_x_mm_s = 100\n[video]\nwidth = "
        "160\nheight = 120\nframe_rate_hz = 1000\nframes = 20\n[camera]\nmm_per_px = 0.05\n[disc]\nradius_px "
        "= "
        "12\nscratches = 0\nhighlight = 0\n[surface]\ntexture_rms = 0\n");
    ASSERT_EQ(run("synth scene.toml -o a.cine -q").exit_code, 0);
    job_.video = in_folder("a.cine");
    job_.mm_per_px = 0.05;
  }
  RecordingJob job_;
};

// A recording that is still being copied must not be recorded as the one that was tracked.
TEST_F(TrackRecording, ARecordingThatChangesMeanwhileIsRefused) {
  job_.track.progress = [&](std::int64_t, std::int64_t) {
    std::ofstream(in_folder("a.cine"), std::ios::app) << "more";
  };
  EXPECT_THAT(complaint_of([&] { track_recording(prepare(job_), "t.csv"); }),
              HasSubstr("a.cine: changed while"));
}

TEST_F(TrackRecording, TheKeyIsThatOfWhatWasTracked) {
  const PreparedJob prepared = prepare(job_);
  const TrackedRecording recording = track_recording(prepared, "t.csv");
  std::ofstream(in_folder("a.cine"), std::ios::app) << "more";
  write_track(in_folder("a.csv"), prepared, recording);
  EXPECT_TRUE(is_current(in_folder("a.csv"), prepared.key));
  EXPECT_FALSE(is_current(in_folder("a.csv"), prepare(job_).key));
}

// Whatever lies beside the pictures of a recording is not part of it.
TEST_F(TrackRecording, ANoteBesideThePicturesChangesNothing) {
  fs::create_directory(in_folder("p"));
  ASSERT_EQ(run("synth scene.toml -o p/%04d.png -q").exit_code, 0);
  fs::remove(in_folder("p/%04d.png.meta.json"));
  for (const char* video : {"p", "p/%04d.png"}) {
    job_.video = in_folder(video);
    const std::string key = prepare(job_).key;
    put(in_folder("p/notes.txt"), video);
    put(in_folder("p/plot.png.txt"), video);
    EXPECT_EQ(prepare(job_).key, key) << video;
  }
}

}  // namespace
}  // namespace tribotrack::apps
