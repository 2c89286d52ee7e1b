// The benchmarks' recordings on disk: a disc goes round, beside a mark, over a platform that rests or over a
// brushed one that moves; 8 bits.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "vision/frame_source.h"
#include "vision/scene.h"

namespace tribotrack::bench {

/// Contrast of the disc 90 grey levels, its path 14 px in radius. A brushed platform (texture 10 grey levels
/// rms) goes round by 5.6 px, and the mark with it; a plain one has no texture and rests.
class CirclingScene {
 public:
  static constexpr int kPoses = 60;          ///< frames of one turn; poses repeat then, the noise does not
  static constexpr double kNoise = 2;        ///< grey levels
  static constexpr double kMarkRadius = 12;  ///< px

  CirclingScene(int width, int height, double radius, bool brushed);
  const vision::Scene& scene() const { return scene_; }
  bool brushed() const { return brushed_; }
  vision::ScenePose pose(int frame) const;
  vision::Circle part(int frame) const;
  vision::Circle mark(int frame) const;

 private:
  vision::Scene scene_;
  bool brushed_ = false;
};

/// How far positions lie from where the part is.
class PositionErrors {
 public:
  explicit PositionErrors(const CirclingScene& scene) : scene_(scene) {}
  void see(int frame, const vision::Point& position);
  /// Px per coordinate, the mean error left out; 0 from fewer than four positions.
  double rms() const;

 private:
  const CirclingScene& scene_;
  vision::Point sum_;
  double square_ = 0, count_ = 0;
};

/// Writes recordings of a scene. Its poses are rendered once, when the first is written.
class CirclingRecorder {
 public:
  explicit CirclingRecorder(const CirclingScene& scene) : scene_(scene) {}
  /// The same frames into each of these files, coded as their names say. Throws vision::InputError.
  void write(int frames, const std::vector<std::filesystem::path>& files);

 private:
  CirclingScene scene_;
  std::vector<vision::Picture> exact_;
};

/// Opens a recording at the benchmarks' frame rate: a container states a playback rate only.
std::unique_ptr<vision::FrameSource> open_recording(const std::filesystem::path& file);

/// A folder of our own among the temporary ones, gone at the end. Throws vision::InputError.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace tribotrack::bench
