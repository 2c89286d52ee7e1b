// Where the time goes: every moment of the tracking belongs to exactly one stage.
#pragma once

#include <array>
#include <chrono>
#include <thread>
#include <vector>

#include "vision/frame_source.h"
#include "vision/track.h"

namespace tribotrack::vision {

enum class Stage {
  reading,
  camera,
  finding,
  setup,
  part,
  marker,
  lamp,
  radius,
  layers_learning,
  layers_measuring,
  edge,
  rotation,
  audit,
  debug_pictures,
  other,
};
const char* to_string(Stage stage);

/// A stage that calls another is interrupted by it, so that the times add up to the whole. A change of stage
/// costs one reading of the steady clock. Only the thread that made the clock changes stages: what others do
/// meanwhile belongs to the stage in which they were started.
class StageClock {
 public:
  class [[nodiscard]] Running {
   public:
    ~Running() { clock_.switch_to(interrupted_); }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

   private:
    friend class StageClock;
    Running(StageClock& clock, Stage stage)
        : clock_(clock), interrupted_(clock.is_own() ? clock.now_in_ : Stage::other) {
      clock.switch_to(stage);
    }
    StageClock& clock_;
    Stage interrupted_;
  };

  /// Time counts for `stage` until what is returned is destroyed, then again for the interrupted stage.
  Running enter(Stage stage) { return {*this, stage}; }
  /// Of the stages that took any, in the order of the work.
  std::vector<StageTime> times();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kStages = static_cast<std::size_t>(Stage::other) + 1;
  bool is_own() const { return std::this_thread::get_id() == owner_; }
  void switch_to(Stage next) {
    if (!is_own()) return;
    const Clock::time_point now = Clock::now();
    spent_[static_cast<std::size_t>(now_in_)] += now - since_;
    since_ = now;
    now_in_ = next;
  }
  std::thread::id owner_ = std::this_thread::get_id();
  Stage now_in_ = Stage::other;
  Clock::time_point since_ = Clock::now();
  std::array<Clock::duration, kStages> spent_{};
};

/// A recording whose reads count as Stage::reading.
class TimedSource : public FrameSource {
 public:
  /// Keeps references.
  TimedSource(FrameSource& source, StageClock& clock) : source_(source), clock_(clock) {
    info_ = source.info();
  }
  using FrameSource::read;
  void read(std::int64_t index, const Rect& window, Picture& picture) override {
    const auto timed = clock_.enter(Stage::reading);
    source_.read(index, window, picture);
  }

 private:
  FrameSource& source_;
  StageClock& clock_;
};

}  // namespace tribotrack::vision
