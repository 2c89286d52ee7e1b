// Photron recordings: the text files that the cameras leave beside them, .cih (lines "Key : value") and .cihx
// (XML), and bare pixels, .mraw, whose shape these state.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

struct PhotronSidecar {
  std::filesystem::path file;
  double rate_hz = 0;           ///< of recording; 0 where it states none
  double step = 1;              ///< every n-th frame was saved
  bool random_trigger = false;  ///< frames come in bursts, with pauses of any length between them
  std::optional<double> exposure_s;
  std::string camera, colour;  ///< "Mono", "Raw", "Color"
  // Of the .mraw; 0 where not stated.
  std::int64_t width = 0, height = 0, frames = 0, first_frame = 0;
  std::int64_t stored_bits = 0, bits = 0;  ///< of a pixel in the file, and the significant ones of these
  bool high_side = false;                  ///< which are the upper ones

  /// The rate at which frames were saved, with what it is worth, behind `candidates`; exposure and camera
  /// where `info` has none yet.
  void describe(SourceInfo& info, std::vector<TimeBaseCandidate>& candidates) const;
};

PhotronSidecar read_photron_sidecar(const std::filesystem::path& file);

/// The .cih or .cihx of a recording: of the same name beside a file; for pictures of a folder or a pattern,
/// given the first of them, that which has the pictures' name without their number, or the only one in their
/// folder.
std::optional<std::filesystem::path> photron_sidecar(const std::filesystem::path& recording);
std::optional<std::filesystem::path> photron_sidecar_of_pictures(const std::filesystem::path& first);

/// The .mraw that a path names, by itself or by its .cih or .cihx; nothing for other names.
std::optional<std::filesystem::path> mraw_named(const std::filesystem::path& path);

/// Pixels of 8, 12 (two in three bytes) or 16 bits, row by row, frame after frame. Throws InputError where
/// the .cih or .cihx is missing or does not fit.
std::unique_ptr<FrameSource> open_mraw(const std::filesystem::path& pixels, const SourceOptions& options);

}  // namespace tribotrack::vision
