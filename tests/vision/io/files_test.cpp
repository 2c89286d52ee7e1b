#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "vision/temporary_file.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

class TemporaryFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tribotrack-test-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  static std::string content_of(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  fs::path folder_;
};

TEST_F(TemporaryFiles, AFileWrittenAnewKeepsItsMode) {
  const fs::path target = folder_ / "x.csv";
  std::ofstream(target) << "before";
  fs::permissions(target, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_exec);
  const fs::perms mode = fs::status(target).permissions();
  TemporaryFile file(target);
  file.write(std::string_view("after"));
  file.commit();
  EXPECT_EQ(content_of(target), "after");
  EXPECT_EQ(fs::status(target).permissions(), mode);
}

TEST_F(TemporaryFiles, NamesAreNotToBeForeseenAndNoLinkIsFollowed) {
  const fs::path target = folder_ / "x.csv", victim = folder_ / "victim";
  std::ofstream(victim) << "mine";
  TemporaryFile file(target), other(target);
  EXPECT_NE(file.path().string().substr(0, file.path().string().size() - 4),
            other.path().string().substr(0, other.path().string().size() - 4));
  fs::remove(file.path());
  fs::create_symlink(victim, file.path());
  EXPECT_THROW(file.write(std::string_view("theirs")), OutputError);
  EXPECT_THROW(file.commit(), OutputError);
  EXPECT_EQ(content_of(victim), "mine");
  EXPECT_FALSE(fs::exists(target));
}

TEST(WithRemedy, DescriptorsAndSizesNameTheirs) {
  EXPECT_THAT(with_remedy(EMFILE, "check the path"), ::testing::HasSubstr("ulimit -n"));
  EXPECT_THAT(with_remedy(EFBIG, "check the path"), ::testing::HasSubstr("ulimit -f"));
  EXPECT_EQ(with_remedy(ENOENT, "check the path"), "No such file or directory; check the path");
}

}  // namespace
}  // namespace tribotrack::vision
