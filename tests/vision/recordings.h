// What the tests of recordings share: a folder that goes away, pictures with known levels, real recordings.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "vision/frame_sink.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

class RecordingTest : public ::testing::Test {
 protected:
  RecordingTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / ("tribotrack-" + std::to_string(::getpid()) + "-" +
                                                        test->test_suite_name() + "-" + test->name());
    std::filesystem::create_directories(folder_);
  }
  ~RecordingTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  std::size_t files_in_folder() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()));
  }

 private:
  std::filesystem::path folder_;
};

using FileBytes = std::vector<std::uint8_t>;

inline FileBytes read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return FileBytes((std::istreambuf_iterator<char>(file)), {});
}

inline void write_bytes(const std::filesystem::path& path, const FileBytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Level of a pixel of a test recording: all levels occur, no row, column or frame repeats another.
inline float test_level(std::int64_t frame, int x, int y, int bits) {
  return static_cast<float>((frame * 37 + x * 3 + y * 101 + x * y) % (1 << bits));
}

inline Picture test_picture(std::int64_t frame, int width, int height, int bits) {
  Picture picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) picture.at(x, y) = test_level(frame, x, y, bits);
  return picture;
}

inline void write_recording(const std::filesystem::path& path, const SinkOptions& options, int frames) {
  const auto sink = create_sink(path, options);
  for (int k = 0; k < frames; ++k) sink->write(test_picture(k, options.width, options.height, options.bits));
  sink->close();
}

/// The one sentence with which an attempt is refused; empty where it is not.
template <class Attempt>
std::string refusal_of(const Attempt& attempt) {
  try {
    attempt();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}
/// That of opening a recording and reading every frame.
inline std::string input_error(const std::filesystem::path& path) {
  return refusal_of([&] {
    const auto source = open_source(path);
    for (std::int64_t k = 0; k < source->info().frame_count; ++k) source->read(k);
  });
}

/// Folder of real recordings, empty where TRIBOTRACK_REAL_DATA does not name one.
inline std::filesystem::path real_data() {
  const char* folder = std::getenv("TRIBOTRACK_REAL_DATA");
  return folder ? folder : "";
}

}  // namespace tribotrack::vision
