// What does tracking a recording on disk cost, and what beside its decoding alone?
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace tribotrack::bench {

struct VisionDecodingOptions {
  int width = 1280, height = 800;  ///< px
  double radius = 60;              ///< px
  int frames = 600;
  int repetitions = 3;
  std::function<void(int done, int total)> progress;
};

/// A few small pictures: shows that it works.
VisionDecodingOptions quick_decoding_options();

/// A disc (contrast 90 grey levels) goes round by 14 px, noise 2 grey levels, 8 bits; a brushed platform
/// (texture 10 grey levels rms) goes round by 5.6 px. Written to the folder for temporary files by this
/// program, read back through the system's cache.
struct VisionDecodingRow {
  std::string coding;  ///< "cine" (uncompressed), "ffv1", "mjpeg", "h264"
  bool brushed = false;
  double radius = 0;  ///< px
  int frames = 0;
  bool layered = false;  ///< what the plan chose
  int lost = 0;
  double rms = 0;       ///< px per coordinate, mean offset removed: of the coding too
  double decoding = 0;  ///< s per frame, opening and decoding alone in one thread: median of the repetitions
  double tracking = 0;  ///< s per frame, opening and all of `track`, likewise, taking turns
};

/// Uncompressed, a window costs next to nothing to read: `decoding` is that of reading 16 x 16 px there.
/// Throws InputError where the files cannot be written.
std::vector<VisionDecodingRow> bench_decoding(const VisionDecodingOptions& options = {});

}  // namespace tribotrack::bench
