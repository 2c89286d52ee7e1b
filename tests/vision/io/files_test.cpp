#include <gmock/gmock.h>

#include "vision/recordings.h"
#include "vision/temporary_file.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

class TemporaryFiles : public RecordingTest {};

std::string content_of(const fs::path& path) {
  const FileBytes bytes = read_bytes(path);
  return {bytes.begin(), bytes.end()};
}

TEST_F(TemporaryFiles, AFileWrittenAnewKeepsItsMode) {
  const fs::path target = file("x.csv");
  std::ofstream(target) << "before";
  fs::permissions(target, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_exec);
  const fs::perms mode = fs::status(target).permissions();
  TemporaryFile written(target);
  written.write(std::string_view("after"));
  written.commit();
  EXPECT_EQ(content_of(target), "after");
  EXPECT_EQ(fs::status(target).permissions(), mode);
}

TEST_F(TemporaryFiles, NamesAreNotToBeForeseenAndNoLinkIsFollowed) {
  const fs::path target = file("x.csv"), victim = file("victim");
  std::ofstream(victim) << "mine";
  TemporaryFile written(target), other(target);
  EXPECT_NE(written.path().string().substr(0, written.path().string().size() - 4),
            other.path().string().substr(0, other.path().string().size() - 4));
  fs::remove(written.path());
  fs::create_symlink(victim, written.path());
  EXPECT_THROW(written.write(std::string_view("theirs")), OutputError);
  EXPECT_THROW(written.commit(), OutputError);
  EXPECT_EQ(content_of(victim), "mine");
  EXPECT_FALSE(fs::exists(target));
}

}  // namespace
}  // namespace tribotrack::vision
