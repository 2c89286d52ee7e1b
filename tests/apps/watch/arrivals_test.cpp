#include "apps/watch/arrivals.h"

#include <gmock/gmock.h>

#include <fstream>

#include "apps/program.h"
#include "apps/program/errors.h"
#include "vision/frame_sink.h"

namespace tribotrack::apps {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

class ArrivalsTest : public testing::Test {
 protected:
  ArrivalsTest() {
    vision::SinkOptions options;
    options.width = 32;
    options.height = 24;
    options.frame_rate_hz = 100;
    const auto sink = vision::create_sink(elsewhere_.path() / "whole.cine", options);
    for (int k = 0; k < 20; ++k) sink->write(vision::Picture(32, 24, static_cast<float>(10 * k)));
    sink->close();
    std::ifstream file(elsewhere_.path() / "whole.cine", std::ios::binary);
    whole_.assign(std::istreambuf_iterator<char>(file), {});
  }
  fs::path in(const std::string& name) const { return folder_.path() / name; }
  void write(const std::string& name, std::size_t bytes) const {
    std::ofstream(in(name), std::ios::binary).write(whole_.data(), static_cast<std::streamsize>(bytes));
  }

  test::TemporaryFolder folder_, elsewhere_;
  std::string whole_;
};

TEST_F(ArrivalsTest, ARecordingIsHandedOutOnceItIsWhole) {
  Arrivals arrivals(folder_.path(), {.settled_s = 0.05, .give_up_s = 1000, .poll_s = 0.01});
  write("a.cine", whole_.size() / 2);
  EXPECT_THAT(arrivals.next(0.3), IsEmpty()) << "its header promises more";
  EXPECT_THAT(arrivals.unfinished(), ElementsAre(in("a.cine")));
  write("a.cine", whole_.size());
  EXPECT_THAT(arrivals.next(10), ElementsAre(in("a.cine")));
  EXPECT_THAT(arrivals.next(0.1), IsEmpty());
  EXPECT_THAT(arrivals.unfinished(), IsEmpty());
}

TEST_F(ArrivalsTest, OneThatWillNeverOpenIsHandedOutInTheEnd) {
  write("a.cine", whole_.size() / 2);
  Arrivals arrivals(folder_.path(), {.settled_s = 0.05, .give_up_s = 0.3, .poll_s = 0.01});
  EXPECT_THAT(arrivals.next(10), ElementsAre(in("a.cine"))) << "so that the user is told what is wrong";
}

TEST_F(ArrivalsTest, ARecordingThatIsReplacedComesAgain) {
  Arrivals arrivals(folder_.path(), {.settled_s = 0.05, .give_up_s = 1000, .poll_s = 0.01});
  write("a.cine", whole_.size());
  EXPECT_THAT(arrivals.next(10), ElementsAre(in("a.cine")));
  fs::rename(elsewhere_.path() / "whole.cine", in("b.cine"));
  EXPECT_THAT(arrivals.next(10), ElementsAre(in("b.cine"))) << "moved there";
  fs::last_write_time(in("a.cine"), fs::last_write_time(in("a.cine")) + std::chrono::seconds(5));
  EXPECT_THAT(arrivals.next(10), ElementsAre(in("a.cine")));
}

TEST_F(ArrivalsTest, NotesAndHiddenFilesAreNoRecordings) {
  std::ofstream(in("notes.txt")) << "x";
  std::ofstream(in(".a.cine")) << whole_;
  Arrivals arrivals(folder_.path(), {.settled_s = 0, .give_up_s = 0, .poll_s = 0.01});
  EXPECT_THAT(arrivals.next(0.1), IsEmpty());
  EXPECT_THAT(arrivals.unfinished(), IsEmpty());
}

}  // namespace
}  // namespace tribotrack::apps
