// The folder that `run` fills and `report` reads, and the file beside each result.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "vision/frame_source.h"
#include "vision/picture.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

// The file beside each result that records how it was made.

/// X.meta.json for result X: program and schema version, inputs with their hashes, effective configuration,
/// and whatever a command adds (time base, plan). Nothing volatile: same inputs, same bytes.
struct MetaFile {
  std::string command;
  std::vector<Input> inputs;
  Json configuration = Json::object();
  Json more = Json::object();
  Json json() const;
  void write_beside(const std::filesystem::path& result) const;
};

/// Throws InvalidInput where a meta file was written by a newer version than this.
void require_known_schema(const Json& meta, const std::filesystem::path& file);

/// A result and its meta file; where `path` is the standard output, the result alone goes there.
void write_result(const std::filesystem::path& path, std::string_view text, const MetaFile& meta);

/// What a recording says of its frames' times and of their picture's axes, with the images that repeat the
/// one before; of gaps the image before each, and how many frames are missing in all.
Json json_of(const vision::SourceInfo& info, const std::vector<std::int64_t>& repeats, bool weaved);
Json json_of(const std::vector<vision::PlanStage>& plan);
Json json_of(const std::vector<vision::SlowPart>& slow);
Json json_of(const vision::Audit& audit);
Json json_of(const vision::CodedErrors& coded);

/// [x, y, radius]; null where there is none.
Json circle_json(const std::optional<vision::Circle>& circle);
Json rect_json(const std::optional<vision::Rect>& rect);

// The folder that `run` fills and `report` reads: what lies where, and who may write.

/// DIR/
///   fit.json, report.html, runs.csv, parameters.csv, report.txt, run.json
///   tracks/NAME.csv, NAME.png (overlay), NAME.first.jpg (first analysed frame, reduced);
///     NAME.log where a job of its own (`track --campaign`) could not make the track: why
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
  /// Says why there is no T.csv where a job of its own could not use the recording; empty or missing
  /// otherwise.
  static std::filesystem::path failure_beside(std::filesystem::path track) {
    return track.replace_extension(".log");
  }
  std::filesystem::path overlay(const std::string& name) const { return tracks() / (name + ".png"); }
  std::filesystem::path first_frame(const std::string& name) const {
    return tracks() / (name + ".first.jpg");
  }
  std::filesystem::path measurements() const { return root / "measurements"; }
  std::filesystem::path measurement(const std::string& name) const {
    return measurements() / (name + ".json");
  }
  std::filesystem::path fit() const { return root / "fit.json"; }
  std::filesystem::path report() const { return root / "report.html"; }
  std::filesystem::path runs_table() const { return root / "runs.csv"; }
  std::filesystem::path parameter_table() const { return root / "parameters.csv"; }
  std::filesystem::path text() const { return root / "report.txt"; }
  std::filesystem::path log() const { return root / "run.json"; }
  std::filesystem::path lock() const { return root / ".lock"; }

  /// The files here that a report is made from.
  std::vector<std::filesystem::path> files_of_report() const;
  /// What is there of a run.
  std::vector<std::filesystem::path> files_of(const std::string& run) const;
  /// Those with a track, whether they belong to the campaign or have left it.
  std::vector<std::string> runs() const;
};

/// The right to write into a run folder, for one process at a time: an advisory lock on DIR/.lock, which the
/// kernel lets go when the process ends, however it ends. Makes the folder and those inside it where they are
/// missing; at the end those that are empty go.
class RunFolderLock {
 public:
  /// Where another process holds it, waits, or throws InvalidInput at once, naming process, host and
  /// campaign.
  RunFolderLock(const RunFolder& folder, const std::filesystem::path& campaign, bool wait = false);
  ~RunFolderLock();
  RunFolderLock(const RunFolderLock&) = delete;
  RunFolderLock& operator=(const RunFolderLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

/// The holder of the lock of a run folder, as "process 12 on host (campaign c.toml)"; nullopt if it is free.
std::optional<std::string> writer_of(const RunFolder& folder);

}  // namespace tribotrack::apps
