// What the fuzz targets (targets.cpp) share: hostile input is read or refused, in the program's own words and
// within a second.
#pragma once

#include <unistd.h>

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

/// What a file from a stranger holds.
struct Hostile {
  const Folder& folder;
  std::string_view text;

  std::filesystem::path as(const std::string& name) const { return folder.write(name, text); }

  /// It is either read or refused, within a second.
  template <class Read>
  void read_or_refuse(const Read& read) const {
    const std::clock_t begin = std::clock();
    try {
      read();
    } catch (const apps::InvalidInput& refusal) {
      require_own_words(refusal.what(), text);
    } catch (const vision::InputError& refusal) {
      require_own_words(refusal.what(), text);
    } catch (const fit::DataError& refusal) {
      require_own_words(refusal.what(), text);
    } catch (const model::InvalidParameter& refusal) {
      require_own_words(refusal.what(), text);
    }
    if (std::clock() - begin > CLOCKS_PER_SEC) find("it took longer than a second");
  }
};

}  // namespace tribotrack::fuzz
