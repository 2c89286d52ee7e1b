// The folder that `run` fills and `report` reads: what lies where, and who may write.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tribotrack::apps {

/// DIR/
///   fit.json, report.html, run.json
///   tracks/NAME.csv, NAME.png (overlay), NAME.first.png (first analysed frame)
///   measurements/NAME.json
///   .lock while a `run` is writing
/// and a meta file beside each table and fit.json.
struct RunFolder {
  std::filesystem::path root;
  std::filesystem::path tracks() const { return root / "tracks"; }
  std::filesystem::path track(const std::string& name) const { return track_in(tracks(), name); }
  static std::filesystem::path track_in(const std::filesystem::path& tracks, const std::string& name) {
    return tracks / (name + ".csv");
  }
  std::filesystem::path overlay(const std::string& name) const { return tracks() / (name + ".png"); }
  std::filesystem::path overlay_video(const std::string& name) const { return tracks() / (name + ".mp4"); }
  std::filesystem::path first_frame(const std::string& name) const {
    return tracks() / (name + ".first.png");
  }
  std::filesystem::path measurements() const { return root / "measurements"; }
  std::filesystem::path measurement(const std::string& name) const {
    return measurements() / (name + ".json");
  }
  std::filesystem::path fit() const { return root / "fit.json"; }
  std::filesystem::path report() const { return root / "report.html"; }
  std::filesystem::path log() const { return root / "run.json"; }
  std::filesystem::path lock() const { return root / ".lock"; }

  /// The files here that a report is made from.
  std::vector<std::filesystem::path> files_of_report() const;
  /// Runs that lie here but are none of `names`, in order.
  std::vector<std::string> runs_besides(const std::vector<std::string>& names) const;
};

/// The right to write into a run folder, for one process at a time: an advisory lock on DIR/.lock, which the
/// kernel lets go when the process ends, however it ends. Makes the folder and those inside it where they are
/// missing; at the end those it made go again if they are still empty.
class RunFolderLock {
 public:
  /// Throws InvalidInput at once where another process holds it, naming process, host and campaign.
  RunFolderLock(const RunFolder& folder, const std::filesystem::path& campaign);
  ~RunFolderLock();
  RunFolderLock(const RunFolderLock&) = delete;
  RunFolderLock& operator=(const RunFolderLock&) = delete;

 private:
  std::filesystem::path file_;
  std::vector<std::filesystem::path> made_;
  int descriptor_ = -1;
};

/// Who is writing into a run folder now: "process 12 on host (campaign c.toml)"; nothing where nobody is.
std::optional<std::string> writer_of(const RunFolder& folder);

}  // namespace tribotrack::apps
