#include "vision/formats/libav/library.h"

#include "vision/io/shared_library.h"

namespace tribotrack::vision {
namespace {

/// libavformat brings the libavcodec and libavutil it was built with, whose functions it finds as well.
Libav load() {
  const std::string version = std::to_string(LIBAVFORMAT_VERSION_MAJOR);
  const SharedLibrary library("libavformat.so." + version, "libavformat" + version, "video files");
  Libav functions;
#define TRIBOTRACK_FIND(name) library.find(#name, functions.name);
  TRIBOTRACK_LIBAV_FUNCTIONS(TRIBOTRACK_FIND)
#undef TRIBOTRACK_FIND
  return functions;
}

}  // namespace

const Libav& libav() {
  static const Libav functions = load();
  return functions;
}

}  // namespace tribotrack::vision
