#include "vision/io/jpeg.h"

#include <gtest/gtest.h>

#include "vision/formats/pictures/imgcodecs.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using JpegTest = RecordingTest;

TEST_F(JpegTest, AnotherReaderFindsThePictureInIt) {
  cv::Mat image(50, 70, CV_8UC1);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image.at<unsigned char>(y, x) = static_cast<unsigned char>(2 * x + y);
  write_bytes(file("a.jpg"), jpeg_of(image, 90));
  const cv::Mat read = read_picture(file("a.jpg").string());
  ASSERT_EQ(read.size(), image.size());
  ASSERT_EQ(read.channels(), 1);
  EXPECT_LT(cv::norm(read, image, cv::NORM_INF), 6);
}

TEST_F(JpegTest, ALowerQualityTakesLessRoom) {
  cv::Mat noise(100, 100, CV_8UC1);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  EXPECT_LT(2 * jpeg_of(noise, 20).size(), jpeg_of(noise, 95).size());
}

TEST_F(JpegTest, OtherKindsOfPictureAreRefused) {
  EXPECT_THROW(jpeg_of(cv::Mat(4, 4, CV_16UC1), 80), std::invalid_argument);
  EXPECT_THROW(jpeg_of(cv::Mat(), 80), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::vision
