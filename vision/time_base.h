// Where the times of a recording's frames come from, and what its timestamps show: missing frames, a rate
// that changed.
//
// Everything dynamic a track yields is proportional to the frame rate, and most video files state the rate of
// playback rather than that of recording. A rate is therefore used only where its source is known to mean
// recording; every source that was considered is kept with the reason why it was accepted or rejected.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tribotrack::vision {

/// Steps between frame `first` and frame `last` (indices, both included) take the same time.
struct SteadyStretch {
  std::int64_t first = 0, last = 0;
  double rate_hz = 0;
};

/// Frames that should stand between frame `after` and the next, and do not.
struct MissingFrames {
  std::int64_t after = 0;
  std::int64_t count = 0;  ///< by the stamps
};

struct StampCheck {
  double rate_hz = 0;     ///< steps over the time they take, gaps left out; of the longest stretch
  double jitter = 0;      ///< median absolute deviation of the steps from their median, of a step
  bool uniform = true;    ///< no step is missing or differs
  bool variable = false;  ///< the steps differ all along: neither drops nor a few stretches explain them
  std::vector<SteadyStretch> stretches;  ///< two or more where the rate changed within the shot
  std::vector<MissingFrames> missing;
  /// Their timestamps are too far from their neighbours' to belong to them (1000 steps and more).
  std::vector<std::int64_t> strays;
  std::int64_t missing_frames() const {
    std::int64_t count = 0;
    for (const MissingFrames& gap : missing) count += gap.count;
    return count;
  }
};

/// One sentence for each finding, with image numbers counted from first_number; at most a few of each kind.
std::vector<std::string> findings(const StampCheck& check, std::int64_t first_number);

/// One statement of the frame rate, in or beside the file, and whether it is used.
struct TimeBaseCandidate {
  std::string source;  ///< "--fps", "cine header", "container time stamps", ...
  double rate_hz = 0;
  bool accepted = false;
  std::string reason;  ///< why it was accepted or rejected, one clause
};

/// Time of frame k, the middle of its exposure: stamps_s[k] where frames have timestamps of their own, else
/// k / rate. 0 at the first stored image. Order of trust: the user, camera header or sidecar, capture tag
/// (com.android.capture.fps), uniform container timestamps whose rate is not a usual playback rate (24, 25,
/// 29.97, 30, 50, 59.94, 60, 600, 1000, 65535).
struct TimeBase {
  std::optional<double> rate_hz;
  std::string source;            ///< that of the accepted candidate
  std::vector<double> stamps_s;  ///< one per frame, or empty
  std::vector<TimeBaseCandidate> candidates;
  StampCheck check;  ///< missing frames and changes of the rate; empty where there are no timestamps

  bool known() const { return rate_hz.has_value(); }
  double time_s(std::int64_t index) const {
    return stamps_s.empty() ? static_cast<double>(index) / rate_hz.value()
                            : stamps_s[static_cast<std::size_t>(index)];
  }
  /// For the user who must give --fps: what was found and why it was not used, one sentence.
  std::string why_unknown() const;
};

/// Rates that players and muxers write independently of the camera: 24, 25, 29.97, 30, 50, 59.94, 60, 600,
/// 1000 and 65535, within the tolerance (0.15 % takes in 23.976). The nominal rate, or nothing.
std::optional<double> usual_playback_rate(double rate_hz, double tolerance = 0.0015);

/// The rate given by the user, and how the user knows. Throws InputError unless it is a positive finite
/// number.
TimeBaseCandidate user_rate(double rate_hz, const std::string& reason = {});

/// Throws InputError where the user gives, without a reason, the very playback rate (24 to 60 Hz) that
/// `stated`, the container's, was rejected for: it is no evidence of the rate of recording.
void require_reason(double user_rate_hz, const std::string& reason, const TimeBaseCandidate& stated);

/// Takes the first candidate marked accepted, in the order given (the most trusted first); marks later ones
/// rejected, with the reason.
TimeBase choose_time_base(std::vector<TimeBaseCandidate> candidates);

}  // namespace tribotrack::vision
