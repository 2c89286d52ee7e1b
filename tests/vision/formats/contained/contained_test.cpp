#include "vision/formats/contained/contained.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "vision/formats/contained/confinement.h"
#include "vision/formats/contained/messages.h"

namespace tribotrack::vision {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 37, kHeight = 23;
constexpr std::int64_t kFrames = 40;

/// Frames that are known in closed form. `at_frame` is called in the process that decodes.
class KnownSource : public DecodedSource {
 public:
  explicit KnownSource(std::size_t bytes_per_level, std::function<void(std::int64_t)> at_frame = {})
      : bytes_(bytes_per_level), at_frame_(std::move(at_frame)) {
    info_.path = "known";
    info_.format = "f";
    info_.codec = "c";
    info_.width = kWidth;
    info_.height = kHeight;
    info_.bits = 16;
    info_.colour = info_.decoded = true;
    info_.coder = Coder{"x264", "crf=18", 16, true, 12.5, 0.5, true, 3.25};
    info_.frame_count = kFrames;
    info_.first_number = -7;
    info_.numbers.assign(kFrames, 8);
    info_.time_base.rate_hz = 250.5;
    info_.time_base.source = "stamps";
    info_.time_base.stamps_s.assign(kFrames, 0.75);
    info_.time_base.candidates = {{"--fps", 30, false, "playback"}, {"header", 250.5, true, ""}};
    info_.time_base.check.stretches = {{0, 3, 250}, {4, 9, 125}};
    info_.time_base.check.missing = {{3, 2}};
    info_.time_base.check.strays = {11};
    info_.exposures_s.assign(kFrames, 1e-3);
    info_.white_level = 235;
    info_.pixel_aspect = 1.25;
    info_.rotation_deg = -90;
    info_.camera = "v711";
    info_.notes = {"one", "", "three"};
  }
  static float level(std::int64_t k, int x, int y) {
    return static_cast<float>((1009 * k + 31 * x + 17 * y) % 256);
  }
  StoredFrame decode(std::int64_t index) override {
    if (at_frame_) at_frame_(index);
    coded_ = {'P', 5, 3, std::vector<CodedCell>(15, {CodedCell::Kind::moving, static_cast<float>(index)})};
    bytes_of_frame_.assign(kWidth * kHeight * bytes_, 0);
    picture_ = Picture(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        bytes_of_frame_[bytes_ * static_cast<std::size_t>(y * kWidth + x)] =
            static_cast<std::uint8_t>(level(index, x, y));
        picture_.at(x, y) = level(index, x, y) + 0.25F;
      }
    if (bytes_ == 4) return stored_in(picture_);
    const int bytes = static_cast<int>(bytes_);
    return {bytes_of_frame_.data(), kWidth * bytes, bytes, bytes};
  }
  const CodedFrame* coded() const override { return &coded_; }
  void claim(std::vector<std::int64_t> numbers) { info_.numbers = std::move(numbers); }

 private:
  std::size_t bytes_;
  std::function<void(std::int64_t)> at_frame_;
  std::vector<std::uint8_t> bytes_of_frame_;
  Picture picture_;
  CodedFrame coded_;
};

std::unique_ptr<FrameSource> known(std::size_t bytes_per_level,
                                   const std::function<void(std::int64_t)>& at_frame = {}) {
  return open_contained("known", [&] { return std::make_unique<KnownSource>(bytes_per_level, at_frame); });
}

/// What the process that decodes says of `attempt`, which gives an errno.
std::string answer_to(const std::function<int()>& attempt) {
  const auto source = known(1, [&](std::int64_t) { throw InputError(std::to_string(attempt())); });
  try {
    source->read(0);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ContainedSource, GivesTheSameFramesInAnyOrder) {
  const std::vector<std::vector<std::int64_t>> orders = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 39},
                                                         {39, 38, 37, 1},
                                                         {0, 5, 10, 15, 20, 25, 26, 27, 2},
                                                         {7, 7, 3, 8, 9, 8}};
  for (const std::size_t bytes : {1, 2, 4})
    for (const auto& order : orders) {
      const auto source = known(bytes);
      for (const std::int64_t k : order) {
        const Rect window{3, 2, 30, 20};
        Picture picture;
        source->read(k, window, picture);
        for (const auto& [x, y] : {std::pair{0, 0}, {29, 0}, {11, 19}, {29, 19}})
          ASSERT_EQ(picture.at(x, y), KnownSource::level(k, x + 3, y + 2) + (bytes == 4 ? 0.25F : 0))
              << "frame " << k << " of " << bytes << " bytes";
        const CodedFrame* coded = source->coded(k);
        ASSERT_TRUE(coded);
        EXPECT_EQ(coded->type, 'P');
        EXPECT_EQ(coded->cells.size(), 15U);
        EXPECT_EQ(coded->cells.back().step, static_cast<float>(k));
      }
    }
}

TEST(ContainedSource, SaysWhatTheRecordingIs) {
  const auto source = known(1);
  const SourceInfo &got = source->info(), want = KnownSource(1).info();
  EXPECT_EQ(got.path, want.path);
  EXPECT_EQ(got.width, want.width);
  EXPECT_EQ(got.coder->settings, want.coder->settings);
  EXPECT_EQ(got.coder->step, want.coder->step);
  EXPECT_EQ(got.frame_count, want.frame_count);
  EXPECT_EQ(got.first_number, want.first_number);
  EXPECT_EQ(got.numbers, want.numbers);
  EXPECT_EQ(got.time_base.rate_hz, want.time_base.rate_hz);
  EXPECT_EQ(got.time_base.stamps_s, want.time_base.stamps_s);
  EXPECT_EQ(got.time_base.candidates.at(0).reason, "playback");
  EXPECT_TRUE(got.time_base.candidates.at(1).accepted);
  EXPECT_EQ(got.time_base.check.stretches.at(1).rate_hz, 125);
  EXPECT_EQ(got.time_base.check.missing_frames(), 2);
  EXPECT_EQ(got.time_base.check.strays, want.time_base.check.strays);
  EXPECT_EQ(got.exposure_s, std::nullopt);
  EXPECT_EQ(got.exposures_s, want.exposures_s);
  EXPECT_EQ(got.black_level, std::nullopt);
  EXPECT_EQ(got.white_level, 235);
  EXPECT_EQ(got.rotation_deg, -90);
  EXPECT_EQ(got.notes, want.notes);
}

TEST(ContainedSource, ACrashIsASentenceAboutItsRecording) {
  const auto source = known(1, [](std::int64_t k) {
    if (k == 6) __builtin_trap();
  });
  for (std::int64_t k = 0; k < 6; ++k) EXPECT_EQ(source->read(k).at(0, 0), KnownSource::level(k, 0, 0));
  for (int time = 0; time < 2; ++time)  // what is gone stays so
    try {
      source->read(6);
      FAIL();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("'known'"));
      EXPECT_THAT(error.what(), HasSubstr("crashes its decoder"));
      EXPECT_THAT(error.what(), HasSubstr("export the recording again"));
    }
  EXPECT_EQ(known(1)->read(6).at(0, 0), KnownSource::level(6, 0, 0));
}

TEST(ContainedSource, ListsOfAnotherLengthThanTheRecordingAreRefused) {
  EXPECT_THROW(open_contained("known",
                              [] {
                                auto source = std::make_unique<KnownSource>(1);
                                source->claim({5, 6, 8});
                                return source;
                              }),
               InputError);
}

TEST(ContainedSource, WaitingForAnAnswerEnds) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  set_patience(ends[0], 1);
  std::int64_t number = 0;
  ASSERT_TRUE(send_bytes(ends[1], &number, sizeof number / 2));
  EXPECT_FALSE(receive_bytes(ends[0], &number, sizeof number));
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST(ContainedSource, PassesErrorsOn) {
  const auto failing = [](auto error) {
    return known(1, [error](std::int64_t k) {
      if (k == 3) throw error;
    });
  };
  const auto damaged = failing(InputError("frame 3 is damaged"));
  for (std::int64_t k = 0; k < 3; ++k) damaged->read(k);
  EXPECT_THROW(damaged->read(3), InputError);
  EXPECT_EQ(damaged->read(4).at(0, 0), KnownSource::level(4, 0, 0));
  EXPECT_THROW(failing(std::logic_error("no"))->read(3), std::runtime_error);
  EXPECT_THROW(
      open_contained("x", []() -> std::unique_ptr<DecodedSource> { throw InputError("x is nothing"); }),
      InputError);
}

TEST(ContainedSource, MemoryWithoutEndIsALackOfMemory) {
  const auto greedy = known(1, [](std::int64_t) {
    std::vector<std::unique_ptr<char[]>> all;
    while (all.size() < 4096) all.push_back(std::make_unique_for_overwrite<char[]>(std::size_t{1} << 24));
  });
  EXPECT_THROW(greedy->read(0), std::bad_alloc);
}

TEST(ContainedSource, MayReadFilesAndNothingElse) {
  if (answer_to([] { return ::socket(AF_INET, SOCK_STREAM, 0) < 0 ? errno : 0; }) == "0")
    GTEST_SKIP() << "this kernel does not filter system calls";
  const std::string refused = std::to_string(EPERM), path = ::testing::TempDir() + "written";
  EXPECT_EQ(answer_to([] { return ::open("/proc/self/status", O_RDONLY) < 0 ? errno : 0; }), "0");
  EXPECT_EQ(answer_to([&] { return ::open(path.c_str(), O_WRONLY | O_CREAT, 0600) < 0 ? errno : 0; }),
            refused);
  EXPECT_EQ(answer_to([&] { return ::unlink(path.c_str()) < 0 ? errno : 0; }), refused);
  EXPECT_EQ(answer_to([] { return ::fork() < 0 ? errno : 0; }), refused);
  EXPECT_EQ(answer_to([] { return ::kill(::getppid(), 0) < 0 ? errno : 0; }), refused);
  const rlimit none{};
  EXPECT_EQ(answer_to([&] { return ::prlimit(::getppid(), RLIMIT_CORE, &none, nullptr) < 0 ? errno : 0; }),
            refused);
}

TEST(Confinement, ALoopWithoutEndEnds) {
  const pid_t child = ::fork();
  if (child == 0) {
    allow_cpu(1);
    for (;;) ::getppid();
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_THAT(end_in_words(status), HasSubstr("without end"));
}

}  // namespace
}  // namespace tribotrack::vision
