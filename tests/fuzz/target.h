// What the fuzz targets share. A target is a program of libFuzzer where one is built (preset `fuzz`), and
// otherwise one that reads every file of its corpus once (replay.cpp).
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "apps/program/errors.h"
#include "fit/measurement.h"
#include "model/scenario.h"
#include "vision/picture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace tribotrack::fuzz {

/// A folder for the files of one target; gone when the program ends.
class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() / ("tribotrack-fuzz-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, std::string_view text) const {
    std::filesystem::path file = path_ / name;
    std::ofstream(file, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
    return file;
  }
  std::filesystem::path write(const std::string& name, const std::uint8_t* data, std::size_t size) const {
    return write(name, {reinterpret_cast<const char*>(data), size});
  }

 private:
  std::filesystem::path path_;
};

[[noreturn]] inline void find(const std::string& what) {
  std::fprintf(stderr, "FIND: %s\n", what.c_str());
  std::abort();
}

/// A refusal is one sentence in the program's own words; it may repeat those of the file.
inline void require_own_words(const std::string& message, std::string_view input) {
  for (const char* foreign : {"exception.", "std::", "toml::", "nlohmann", "basic_string", "vector::"})
    if (message.find(foreign) != std::string::npos && input.find(foreign) == std::string_view::npos)
      find("words of a library: " + message);
  if (message.empty()) find("a refusal without a word");
}

/// Reads what may be hostile: it is either read or refused, within a second.
template <class Read>
void read_or_refuse(const std::uint8_t* data, std::size_t size, const Read& read) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::clock_t begin = std::clock();
  try {
    read();
  } catch (const apps::InvalidInput& refusal) {
    require_own_words(refusal.what(), input);
  } catch (const vision::InputError& refusal) {
    require_own_words(refusal.what(), input);
  } catch (const fit::DataError& refusal) {
    require_own_words(refusal.what(), input);
  } catch (const model::InvalidParameter& refusal) {
    require_own_words(refusal.what(), input);
  }
  if (std::clock() - begin > CLOCKS_PER_SEC) find("it took longer than a second");
}

}  // namespace tribotrack::fuzz
