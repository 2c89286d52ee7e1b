// Frames from a recording, whatever its format, at its native depth.
//
// A frame is a Picture of grey levels 0 .. 2^bits - 1, linear in the light where the format says how (the
// companding of Phantom's P10 is undone, colour becomes luma); pixel (x, y) has its centre at whole x, y, the
// origin is the upper left pixel, y points down. Times are seconds, the middle of the exposure, 0 at the
// recording's first stored image. Everything that cannot be read, or not without guessing, is an InputError
// that names file, place and remedy.
//
//   const auto source = open_source("run.cine");
//   Picture frame;
//   for (std::int64_t k = 0; k < source->info().frame_count; ++k) {
//     source->read(k, source->bounds(), frame);
//     std::cout << source->number(k) << " " << source->time_s(k) << " s: " << frame.at(10, 20) << "\n";
//   }
//
// time_s() needs a time base: container files often state a playback rate only. Check
// info().time_base.known() first and give SourceOptions::frame_rate_hz where it is not.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vision/picture.h"
#include "vision/time_base.h"

namespace tribotrack::vision {

/// The codec of a recording with lossy compression; vision/coding says what follows for positions.
struct Coder {
  std::string name;        ///< "x264", "x265", "mjpeg", "mpeg4", "h264 of an unknown coder", ...
  std::string settings;    ///< as the encoder wrote them into the stream; empty if it did not
  int grid = 8;            ///< px: side of the blocks that are quantised separately
  bool all_intra = false;  ///< every frame is coded by itself
  double group = 0;        ///< frames from one key frame to the next, on average; all where only one is there
  /// Coefficients below this many steps are not coded if another frame predicts them.
  double dead_zone = 0.83;
  bool known = false;  ///< which one it was, and with which settings
  double step = 0;     ///< of the quantiser in the first frame (CodedCell), grey levels; 0 unknown
};

/// How the codec stored a part of a frame.
struct CodedCell {
  enum class Kind : unsigned char {
    intra,   ///< by itself
    still,   ///< predicted from the same place of another frame
    moving,  ///< predicted from elsewhere in another frame
  } kind = Kind::intra;
  float step = 0;  ///< of the quantiser, in coefficients of an orthonormal transform, grey levels; 0 unknown
};

/// How the codec stored a frame, by cells of 8 x 8 px, row by row; no cells if the decoder does not tell.
struct CodedFrame {
  static constexpr int kCell = 8;
  char type = '?';  ///< 'I', 'P' or 'B'
  int columns = 0, rows = 0;
  std::vector<CodedCell> cells;
  double mean_step() const;  ///< 0 where unknown
  double still_share() const;
};

/// What a recording is.
struct SourceInfo {
  std::filesystem::path path;
  std::string format;  ///< "cine", "tiff stack", "image sequence", "mov,mp4,...", ...
  std::string codec;   ///< "uncompressed 8 bit", "P10", "h264", ...
  int width = 0;
  int height = 0;
  int bits = 0;         ///< significant bits of the grey levels handed out (after linearisation)
  bool colour = false;  ///< stored in colour and handed out as luma
  /// Any window costs the decoding of the whole frame, and out of order that of others.
  bool decoded = false;
  std::optional<Coder> coder;  ///< of lossy compression; empty if the levels are those of the camera
  std::int64_t frame_count = 0;
  /// The recording's own number of its first stored image (0 unless it has numbers).
  std::int64_t first_number = 0;
  std::vector<std::int64_t> numbers;  ///< of every image, unless they count on from first_number
  TimeBase time_base;
  std::optional<double> exposure_s;  ///< of the first frame where it varies
  std::vector<double> exposures_s;   ///< one per frame where the camera wrote them down, else empty
  /// Grey levels of black and white as handed out, if the file states them: the header of a .cine, or
  /// video in limited range (16 and 235, scaled to the depth).
  std::optional<double> black_level, white_level;
  double pixel_aspect = 1;  ///< width of a pixel over its height, as the file states it
  int rotation_deg = 0;  ///< by which players turn the pictures, counter-clockwise; here they are as stored
  std::string camera;    ///< empty where the file does not state it
  std::string trigger_time;        ///< ISO 8601 UTC, empty where the file does not state it
  std::vector<std::string> notes;  ///< for the user: companding undone, colour converted to luma, ...

  /// Grey level from which on a pixel is saturated.
  double clipping_level() const { return white_level.value_or(std::ldexp(1.0, bits) - 1); }
};

/// Random access to frames. index runs 0 .. frame_count - 1; number = first_number + index. Not thread-safe:
/// open one per thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  const SourceInfo& info() const { return info_; }
  std::int64_t number(std::int64_t index) const {
    return info_.numbers.empty() ? info_.first_number + index
                                 : info_.numbers[static_cast<std::size_t>(index)];
  }
  /// Time of the middle of a frame's exposure, s; 0 at that of the recording's first stored image. Needs a
  /// time base.
  double time_s(std::int64_t index) const { return info_.time_base.time_s(index); }
  /// Exposure of a frame, s; empty if the file does not state it. time_s is its middle.
  std::optional<double> exposure_s(std::int64_t index) const {
    return info_.exposures_s.empty() ? info_.exposure_s : info_.exposures_s[static_cast<std::size_t>(index)];
  }
  Rect bounds() const { return {0, 0, info_.width, info_.height}; }
  /// Reads a window of a frame, which must lie inside bounds(); only its rows, if the format allows it.
  /// Sequential access is fast in every format; the picture's memory is used again. Throws InputError, and
  /// for a frame or a window that is not there std::out_of_range and std::invalid_argument: a caller's
  /// mistake.
  void read(std::int64_t index, const Rect& window, Picture& picture);
  /// How the codec stored one of the last 128 frames that were read; null if that is unknown.
  virtual const CodedFrame* coded(std::int64_t index) const {
    static_cast<void>(index);
    return nullptr;
  }
  Picture read(std::int64_t index) {
    Picture picture;
    read(index, bounds(), picture);
    return picture;
  }

 protected:
  /// What read() reads; the window lies in the frame, and `picture` has its size.
  virtual void fill(std::int64_t index, const Rect& window, Picture& picture) = 0;
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
  void fill(std::int64_t index, const Rect& window, Picture& picture) override;

 private:
  std::vector<Picture> frames_;
};

/// The layout of a recording in memory: level (frame k, row y, column x) at first + k
/// frame_stride + y row_stride + x level_stride. Strides count bytes and may be negative.
struct FrameStack {
  const void* first = nullptr;
  int bytes_per_level = 1;  ///< 1 or 2, in the processor's byte order
  std::int64_t frames = 0;
  int width = 0, height = 0;
  std::ptrdiff_t frame_stride = 0, row_stride = 0, level_stride = 0;
};

/// Frames in the memory of a camera's library or a NumPy array: nothing is copied but the windows that are
/// read. The memory must outlive the source, unchanged; frame 0 is at time 0.
class StackSource : public FrameSource {
 public:
  /// Throws std::invalid_argument for an empty stack, levels of other sizes or more bits than these hold, and
  /// a rate not above 0 Hz.
  StackSource(const FrameStack& stack, double frame_rate_hz, int bits);
  void fill(std::int64_t index, const Rect& window, Picture& picture) override;

 private:
  FrameStack stack_;
};

struct SourceOptions {
  std::optional<double> frame_rate_hz;  ///< given by the user: overrides what the file states
  /// How the user knows. Without it a rate that is only the file's playback rate is refused.
  std::string frame_rate_reason = {};
};

/// Opens a Phantom .cine, anything libav decodes, a multi-page TIFF, a directory of pictures (natural sort),
/// or a printf pattern such as "dir/%05d.png". Videos and pictures are decoded in a process of their own
/// (fork), ahead of where they are read. Throws InputError. A recording whose capture rate is unknown
/// is opened, with an empty time_base.rate_hz and the reasons in its candidates: code that needs times must
/// refuse it.
std::unique_ptr<FrameSource> open_source(const std::filesystem::path& path,
                                         const SourceOptions& options = {});

/// The files on which open_source(path) depends: the recording itself; the pictures of a folder or pattern,
/// in the order of the frames; the camera's text file (.cih, .cihx) that states the capture rate. Throws
/// InputError if there is no such recording.
std::vector<std::filesystem::path> files_of_recording(const std::filesystem::path& path);

/// Bytes of a file before its first picture, for formats that keep the description of every frame there
/// (.cine: times, exposures, positions); else 0.
std::uint64_t bytes_before_pictures(const std::filesystem::path& path);

/// Whether the file's name is a pattern for one number, such as "dir/%05d.png"; the files need not exist.
bool is_number_pattern(const std::filesystem::path& path);

/// For the whole process: OpenCV's functions stay on the calling thread, so that the user's number of threads
/// holds (recordings are processed in parallel), and decode no picture of a size beyond sense. main() calls
/// it, before there is another thread.
void set_up_process();

/// "OpenCV 4.6.0, libavformat 59.27.100, libavcodec 59.37.100": what vision/ stands on, as the program was
/// compiled.
std::string libraries();

}  // namespace tribotrack::vision
