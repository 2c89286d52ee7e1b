#include "vision/formats/libav/libav.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::HasSubstr;

class CoderTest : public RecordingTest {
 protected:
  /// A square that jumps by 8 px a frame over a ground that stands.
  static Picture picture(int k) {
    Picture out(96, 64);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 96; ++x) {
        const int left = 8 + 8 * k;
        const bool inside = x >= left && x < left + 24 && y >= 16 && y < 40;
        out.at(x, y) = static_cast<float>(inside ? 200 : 60 + (x * 7 + y * 13) % 11);
      }
    return out;
  }
  std::unique_ptr<FrameSource> coded(const char* name, SinkOptions sink) {
    sink.width = 96;
    sink.height = 64;
    sink.frame_rate_hz = 25;
    const auto writer = create_sink(file(name), sink);
    for (int k = 0; k < 6; ++k) writer->write(picture(k));
    writer->close();
    return open_source(file(name));
  }
};

TEST_F(CoderTest, X264StatesItsSettingsAndBlocks) {
  const auto source = coded("a.mp4", {.codec = Codec::h264, .crf = 20});
  ASSERT_TRUE(source->info().coder);
  const Coder& coder = *source->info().coder;
  EXPECT_EQ(coder.name, "x264");
  EXPECT_THAT(coder.settings, HasSubstr("crf=20.0"));
  EXPECT_TRUE(coder.known);
  EXPECT_FALSE(coder.all_intra);
  EXPECT_DOUBLE_EQ(coder.dead_zone, 0.5 + 21.0 / 64);
  EXPECT_GT(coder.step, 0.625);
  source->read(0);
  source->read(3);
  ASSERT_TRUE(source->coded(0) && source->coded(3));
  EXPECT_EQ(source->coded(0)->type, 'I');
  EXPECT_EQ(source->coded(0)->still_share(), 0);
  EXPECT_EQ(source->coded(3)->type, 'P');
  EXPECT_EQ(source->coded(3)->columns, 12);
  EXPECT_GT(source->coded(3)->still_share(), 0.4) << "most of the ground stands";
  EXPECT_LT(source->coded(3)->still_share(), 1) << "the square moves";
  EXPECT_FALSE(source->coded(2)) << "was not read";
}

TEST_F(CoderTest, MjpegHasTheStepOfItsTable) {
  const auto source = coded("a.avi", {.codec = Codec::mjpeg});
  ASSERT_TRUE(source->info().coder);
  EXPECT_EQ(source->info().coder->name, "mjpeg");
  EXPECT_TRUE(source->info().coder->all_intra);
  EXPECT_GE(source->info().coder->step, 3);
  EXPECT_LE(source->info().coder->step, 8);
}

TEST_F(CoderTest, LosslessHasNoCoder) {
  const auto source = coded("a.mkv", {.codec = Codec::ffv1});
  EXPECT_FALSE(source->info().coder);
  source->read(1);
  EXPECT_FALSE(source->coded(1));
}

}  // namespace
}  // namespace tribotrack::vision
