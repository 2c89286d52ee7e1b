// Frames from a recording, whatever its format, at its native depth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vision/picture.h"
#include "vision/time_base.h"

namespace tribotrack::vision {

/// What a recording is.
struct SourceInfo {
  std::filesystem::path path;
  std::string format;  ///< "cine", "tiff stack", "image sequence", "mov,mp4,...", ...
  std::string codec;   ///< "uncompressed 8 bit", "P10", "h264", ...
  int width = 0;
  int height = 0;
  int bits = 0;         ///< significant bits of the grey levels handed out (after linearisation)
  bool colour = false;  ///< stored in colour and handed out as luma
  /// Any window of a frame costs the decoding of the whole frame, out of order that of others too.
  bool decoded = false;
  std::int64_t frame_count = 0;
  std::int64_t first_number =
      0;  ///< the recording's own number of its first stored image (0 unless it has numbers)
  TimeBase time_base;
  std::optional<double> exposure_s;  ///< of the first frame where it varies
  std::vector<double> exposures_s;   ///< one per frame where the camera wrote them down, else empty
  std::optional<double> black_level, white_level;  ///< grey levels as handed out, where the file says them
  std::string camera;                              ///< empty where the file does not say
  std::string trigger_time;                        ///< ISO 8601 UTC, empty where the file does not say
  std::vector<std::string> notes;  ///< what a user should know: companding undone, colour turned to luma, ...
};

/// Random access to frames. index runs 0 .. frame_count - 1; number = first_number + index. Not thread-safe:
/// open one per thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  const SourceInfo& info() const { return info_; }
  std::int64_t number(std::int64_t index) const { return info_.first_number + index; }
  /// Time of the middle of a frame's exposure, s; 0 at that of the recording's first stored image. Needs a
  /// time base.
  double time_s(std::int64_t index) const { return info_.time_base.time_s(index); }
  /// How long a frame was exposed, s; nothing where the file does not say. time_s is the middle of it.
  std::optional<double> exposure_s(std::int64_t index) const {
    return info_.exposures_s.empty() ? info_.exposure_s : info_.exposures_s[static_cast<std::size_t>(index)];
  }
  Rect bounds() const { return {0, 0, info_.width, info_.height}; }
  /// Reads a window of a frame, which must lie inside bounds(). Formats that can, read only its rows.
  /// Sequential access is fast in every format. Throws InputError.
  virtual void read(std::int64_t index, const Rect& window, Picture& picture) = 0;
  Picture read(std::int64_t index) {
    Picture picture;
    read(index, bounds(), picture);
    return picture;
  }

 protected:
  SourceInfo info_;
};

/// Pictures in memory as a recording: rendered scenes, frames of a camera's own library. Pictures hold whole
/// or fractional grey levels of `bits` bits; frame 0 is at time 0.
///   MemorySource source(std::move(pictures), 1000);
///   const TrackResult result = track(source, options);
class MemorySource : public FrameSource {
 public:
  /// Throws std::invalid_argument without frames, for frames of different sizes or a rate not above 0 Hz.
  MemorySource(std::vector<Picture> frames, double frame_rate_hz, int bits = 8);
  void read(std::int64_t index, const Rect& window, Picture& picture) override;
  using FrameSource::read;

 private:
  std::vector<Picture> frames_;
};

struct SourceOptions {
  std::optional<double> frame_rate_hz;  ///< the user's word: beats what the file says
};

/// Opens a Phantom .cine, anything libav decodes, a multi-page TIFF, a directory of pictures (natural sort),
/// or a printf pattern such as "dir/%05d.png". Throws InputError. A recording whose capture rate cannot be
/// told opens all the same, with time_base.rate_hz empty and the reasons in its candidates: what needs times
/// must refuse it.
std::unique_ptr<FrameSource> open_source(const std::filesystem::path& path,
                                         const SourceOptions& options = {});

/// Keeps OpenCV's own functions on the calling thread, for the whole process: recordings are worked on side
/// by side, one a thread, and a thread count the user gives then means what it says. A program's own choice,
/// so main() calls it.
void keep_to_calling_thread();

}  // namespace tribotrack::vision
