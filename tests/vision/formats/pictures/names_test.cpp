#include "vision/formats/pictures/pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(NumberPattern, NamesAndNumbersAreInverse) {
  const auto pattern = NumberPattern::parse("dir/frame%04d.png");
  ASSERT_TRUE(pattern);
  EXPECT_EQ(pattern->file(7), "dir/frame0007.png");
  EXPECT_EQ(pattern->file(12345), "dir/frame12345.png");
  EXPECT_EQ(pattern->number_of("frame0007.png"), 7);
  EXPECT_EQ(pattern->number_of("frame12345.png"), 12345);
  for (const char* name :
       {"frame7.png", "frame00007.png", "frame0007.tif", "xframe0007.png", "frame.png", "frame-007.png"})
    EXPECT_FALSE(pattern->number_of(name)) << name;
  EXPECT_EQ(NumberPattern::parse("%d.png")->number_of("7.png"), 7);
  EXPECT_FALSE(NumberPattern::parse("%d.png")->number_of("07.png"));
}

TEST(NumberPattern, OnlyOneNumber) {
  EXPECT_FALSE(NumberPattern::parse("dir%d/a.png"));
  for (const char* name : {"a%s.png", "a%d%d.png", "a%", "a%5", "a%99d.png"})
    EXPECT_THROW(NumberPattern::parse(name), InputError) << name;
  EXPECT_TRUE(is_number_pattern("nowhere/frame%05d.png"));
  EXPECT_FALSE(is_number_pattern("%d%d.png"));
}

class PictureListTest : public RecordingTest {
 protected:
  void touch(const std::vector<std::string>& names) {
    for (const auto& name : names) write_bytes(file(name), {0});
  }
  std::vector<std::string> names(const PictureList& list) {
    std::vector<std::string> out;
    for (const auto& path : list.files) out.push_back(path.filename().string());
    return out;
  }
};

TEST_F(PictureListTest, MissingNumbersAreRefusedAndEveryNthIsCountedFromZero) {
  touch({"f10.png", "f20.png", "f30.png"});
  for (const auto& list :
       {pictures_in_folder(file("")), pictures_of_pattern(*NumberPattern::parse(file("f%d.png")))}) {
    EXPECT_EQ(list.first_number, 0);
    EXPECT_THAT(list.notes, ElementsAre(HasSubstr("step by 10")));
  }
  touch({"f50.png"});
  for (const char* path : {"", "f%d.png"})
    EXPECT_THAT(input_error(file(path)),
                AllOf(HasSubstr("f40.png' is missing between"), HasSubstr("f30.png"), HasSubstr("f50.png")));
}

TEST_F(PictureListTest, PatternBeginsAtItsLowestNumberAndHasNoGap) {
  touch({"f0005.png", "f0006.png", "f0007.png", "f8.png"});
  const auto list = pictures_of_pattern(*NumberPattern::parse(file("f%04d.png")));
  EXPECT_THAT(names(list), ElementsAre("f0005.png", "f0006.png", "f0007.png"));
  EXPECT_EQ(list.first_number, 5);
  touch({"f0009.png"});
  EXPECT_THAT(input_error(file("f%04d.png")), AllOf(HasSubstr("f0008.png"), HasSubstr("missing")));
  EXPECT_THAT(input_error(file("g%04d.png")), HasSubstr("no file matches"));
  EXPECT_THAT(input_error(file("nowhere/g%04d.png")), HasSubstr("nowhere"));
}

TEST_F(PictureListTest, RecordingConsistsOfItsPicturesAlone) {
  touch({"f10.png", "f9.png", "f11.PNG", "notes.txt", "f9.json", "g1.png", ".f11.png"});
  EXPECT_THAT(files_of_recording(file("f%d.png")), ElementsAre(file("f9.png"), file("f10.png")));
  EXPECT_THAT(files_of_recording(file("")),
              ElementsAre(file("f9.png"), file("f10.png"), file("f11.PNG"), file("g1.png")));
  EXPECT_THAT(files_of_recording(file("g1.png")), ElementsAre(file("g1.png")));
  EXPECT_THROW(files_of_recording(file("h%d.png")), InputError);
  EXPECT_THROW(files_of_recording(file("nothing.avi")), InputError);
}

TEST_F(PictureListTest, SidecarThatStatesTheRateBelongsToTheRecording) {
  touch({"run.avi", "run.txt", "run.cih", "other.cih", "alone.avi", "page.tif", "page.cih", "bare.mraw",
         "bare.cihx"});
  EXPECT_THAT(files_of_recording(file("run.avi")), ElementsAre(file("run.avi"), file("run.cih")));
  EXPECT_THAT(files_of_recording(file("alone.avi")), ElementsAre(file("alone.avi")));
  EXPECT_THAT(files_of_recording(file("page.tif")), ElementsAre(file("page.tif"), file("page.cih")));
  for (const char* name : {"bare.mraw", "bare.cihx"})
    EXPECT_THAT(files_of_recording(file(name)), ElementsAre(file("bare.mraw"), file("bare.cihx")));
  std::filesystem::create_directory(file("shot"));
  touch({"shot/shot001.tif", "shot/shot002.tif", "shot/shot.cihx", "shot/other.cihx"});
  EXPECT_THAT(files_of_recording(file("shot")),
              ElementsAre(file("shot/shot001.tif"), file("shot/shot002.tif"), file("shot/shot.cihx")));
}

}  // namespace
}  // namespace tribotrack::vision
