#include "vision/formats/libav/coder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "vision/formats/libav/x264_settings.h"
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

/// The settings read back and given to the encoder again make pictures as far from the truth as before, where
/// the quality asked for would make them several times worse. (The streams are the same byte by byte as a
/// rule, but not always.)
TEST_F(CoderTest, CodingLikeACoderMakesTheSameErrors) {
  const auto error = [](FrameSource& source) {
    double square = 0, n = 0;
    for (int k = 0; k < 6; ++k) {
      const Picture seen = source.read(k), exact = picture(k);
      for (std::size_t i = 0; i < seen.levels().size(); ++i, ++n)
        square += std::pow(static_cast<double>(seen.levels()[i] - exact.levels()[i]), 2);
    }
    return std::sqrt(square / n);
  };
  for (const SinkOptions& sink :
       {SinkOptions{.codec = Codec::h264, .crf = 18}, SinkOptions{.codec = Codec::mjpeg}}) {
    const bool h264 = sink.codec == Codec::h264;
    SCOPED_TRACE(h264 ? "h264" : "mjpeg");
    const auto first = coded(h264 ? "1.mkv" : "1.avi", sink);
    SinkOptions like = sink;
    like.crf = 40;
    like.like = first->info().coder;
    const auto again = coded(h264 ? "2.mkv" : "2.avi", like);
    ASSERT_TRUE(again->info().coder);
    EXPECT_EQ(first->info().coder->settings, again->info().coder->settings);
    EXPECT_NEAR(error(*again), error(*first), 0.1 * error(*first));
    if (!h264) continue;
    like.like.reset();
    EXPECT_GT(error(*coded("3.mkv", like)), 2 * error(*first));
  }
}

TEST(X264Settings, NamesAsTheEncoderTakesThem) {
  const std::string settings =
      "x264 - core 164 - options: cabac=1 deblock=1:-1:2 analyse=0x3:0x133 psy_rd=0.40:0.00 deadzone=6,6 "
      "decimate=0 direct=3 bframes=3 rc=crf crf=18.0 ip_ratio=1.40 aq=0 threads=4";
  const std::string found = x264_parameters(settings);
  for (const char* expected : {"crf=18.00", ":deblock=-1,2", ":partitions=i4x4,i8x8,p8x8,p4x4,b8x8",
                               ":psy_rd=0.40,0.00", ":deadzone-inter=6:deadzone-intra=6", ":dct-decimate=0",
                               ":direct=auto", ":ipratio=1.40", ":aq-mode=0"})
    EXPECT_THAT(found, HasSubstr(expected));
  EXPECT_EQ(found.find("threads"), std::string::npos);
  EXPECT_EQ(b_frames_of(settings), 3);
}

}  // namespace
}  // namespace tribotrack::vision
