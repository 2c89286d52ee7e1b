// Where `run` keeps what, and `report` finds it.
#pragma once

#include <filesystem>
#include <string>

namespace tribotrack::apps {

/// DIR/
///   fit.json, report.html, run.json
///   tracks/NAME.csv, NAME.png (overlay), NAME.first.png (first analysed frame)
///   measurements/NAME.json
/// and a meta file beside each table and fit.json.
struct RunFolder {
  std::filesystem::path root;
  std::filesystem::path tracks() const { return root / "tracks"; }
  std::filesystem::path track(const std::string& name) const { return tracks() / (name + ".csv"); }
  std::filesystem::path overlay(const std::string& name) const { return tracks() / (name + ".png"); }
  std::filesystem::path overlay_video(const std::string& name) const { return tracks() / (name + ".mp4"); }
  std::filesystem::path first_frame(const std::string& name) const {
    return tracks() / (name + ".first.png");
  }
  std::filesystem::path measurement(const std::string& name) const {
    return root / "measurements" / (name + ".json");
  }
  std::filesystem::path fit() const { return root / "fit.json"; }
  std::filesystem::path report() const { return root / "report.html"; }
  std::filesystem::path log() const { return root / "run.json"; }
};

}  // namespace tribotrack::apps
