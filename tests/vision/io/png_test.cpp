#include "vision/io/png.h"

#include <gtest/gtest.h>

#include "vision/formats/pictures/imgcodecs.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

class PngTest : public RecordingTest {
 protected:
  /// Largest difference from what another reader finds in the file; -1 where size or kind differ.
  double difference_when_read(const cv::Mat& image) {
    write_bytes(file("a.png"), png_of(image));
    const cv::Mat read = read_picture(file("a.png").string());
    if (read.size() != image.size() || read.type() != image.type()) return -1;
    return cv::norm(read, image, cv::NORM_INF);
  }
};

TEST_F(PngTest, EveryLevelComesBack) {
  for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3})
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 7), cv::Size(37, 23), cv::Size(300, 200)}) {
      cv::Mat noise(size, type), flat(size, type, cv::Scalar(7, 130, 255));
      cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 65536);
      EXPECT_EQ(difference_when_read(noise), 0) << type << " " << size.width;
      EXPECT_EQ(difference_when_read(flat), 0) << type << " " << size.width;
    }
}

TEST_F(PngTest, PartsOfAPictureAreCodedRowByRow) {
  cv::Mat whole(40, 50, CV_8UC3);
  cv::RNG(2).fill(whole, cv::RNG::UNIFORM, 0, 256);
  EXPECT_EQ(difference_when_read(whole(cv::Rect(3, 5, 20, 30))), 0);
}

TEST_F(PngTest, OtherKindsAreRefused) {
  EXPECT_THROW(png_of(cv::Mat()), std::invalid_argument);
  EXPECT_THROW(png_of(cv::Mat(2, 2, CV_32F)), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::vision
