// The libraries behind vision/, for whoever asks what a program stands on and whether it is all there.
#pragma once

#include <string>
#include <vector>

namespace tribotrack::vision {

struct LibraryState {
  std::string name;     ///< "OpenCV", "libavformat"
  std::string version;  ///< that it was compiled with
  std::string purpose;  ///< "video files"
  std::string missing;  ///< why it cannot be loaded, one sentence; empty where it can, or was not tried
};

/// `load`: try to load those that are otherwise loaded when a file needs them.
std::vector<LibraryState> libraries(bool load);

}  // namespace tribotrack::vision
