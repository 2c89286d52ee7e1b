// Pictures to check a track by eye: a wrong target or a slipping template shows at a glance.
//
//   const auto source = open_source("run.cine");
//   const TrackResult result = track(*source, {});
//   write_overlay(*source, result, "run.png");   // the path over the first analysed frame
//   write_overlay(*source, result, "run.mp4");   // every analysed frame
//
// Drawn in the frame's own pixel coordinates, enlarged where the frame is small. Files appear whole or not at
// all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/survey.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// Throws InputError unless the name ends like an overlay's.
void require_overlay_name(const std::filesystem::path& path);

/// .png: the trajectory over the first analysed frame. .mp4 / .avi / .mkv: every analysed frame with outline,
/// path so far, frame number and status. Throws InputError.
void write_overlay(FrameSource& source, const TrackResult& result, const std::filesystem::path& path);

/// Writes the pictures of the tracking's stages into a folder as PNG files, enlarged, each with a legend, and
/// index.txt: one line per picture with file, title, frame, range and unit, separated by tabs. Files of other
/// names are left alone.
class DebugFolder : public DebugSink {
 public:
  /// Creates the folder. Throws InputError where nothing can be written there.
  explicit DebugFolder(std::filesystem::path folder);
  void show(const StagePicture& picture) override;

 private:
  std::filesystem::path folder_;
  std::string index_;
};

/// A frame, by the recording's own number, as a grey JPEG in memory (for reports), stretched to full range
/// and reduced until its longer side is no more than `largest_side` px.
std::vector<unsigned char> first_frame_jpeg(FrameSource& source, std::int64_t frame_number,
                                            int largest_side = 480);

/// The survey's frame with a pixel grid, its discs numbered from 1 and its lamps from L1, as a PNG in memory.
std::vector<unsigned char> survey_png(FrameSource& source, const Survey& seen);

}  // namespace tribotrack::vision
