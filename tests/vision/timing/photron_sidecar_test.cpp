#include "vision/timing/photron_sidecar.h"

#include <gtest/gtest.h>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

class PhotronSidecarTest : public RecordingTest {
 protected:
  std::optional<TimeBaseCandidate> beside(const std::string& name, const std::string& text) {
    write_bytes(file(name), FileBytes(text.begin(), text.end()));
    return photron_sidecar_rate(file("a.avi"));
  }
};

TEST_F(PhotronSidecarTest, None) {
  EXPECT_FALSE(photron_sidecar_rate(file("a.avi")));
}

TEST_F(PhotronSidecarTest, TextForm) {
  const auto rate =
      beside("a.cih", "Date : 2021/4/1\r\nRecord Rate(fps) : 12500\r\nShutter Speed(s) : 1/20000\r\n");
  ASSERT_TRUE(rate);
  EXPECT_TRUE(rate->accepted);
  EXPECT_EQ(rate->rate_hz, 12500);
}

TEST_F(PhotronSidecarTest, XmlFormBehindItsBinaryHead) {
  const auto rate = beside("a.cihx", std::string("\0\x01\xFF junk", 8) +
                                         "<cih><recordInfo><recordRate>500</recordRate></recordInfo></cih>");
  ASSERT_TRUE(rate);
  EXPECT_TRUE(rate->accepted);
  EXPECT_EQ(rate->rate_hz, 500);
}

TEST_F(PhotronSidecarTest, WithoutARateItIsRejectedWithTheReason) {
  for (const char* text :
       {"Total Frame : 5\r\n", "Record Rate(fps) : many\r\n", "Record Rate(fps) : 0\r\n", ""}) {
    const auto rate = beside("a.cih", text);
    ASSERT_TRUE(rate);
    EXPECT_FALSE(rate->accepted) << text;
    EXPECT_NE(rate->reason.find("Record Rate"), std::string::npos);
  }
}

}  // namespace
}  // namespace tribotrack::vision
