// Where the time goes: every moment of the tracking belongs to exactly one stage.
#pragma once

#include <chrono>
#include <thread>
#include <vector>

#include "vision/frame_source.h"
#include "vision/track.h"

namespace tribotrack::vision {

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
    Running(StageClock& clock, const char* stage)
        : clock_(clock), interrupted_(clock.is_own() ? clock.now_in_ : kOther) {
      clock.switch_to(stage);
    }
    StageClock& clock_;
    const char* interrupted_;
  };

  /// Time counts for `stage` until what is returned is destroyed, then again for the interrupted stage.
  Running enter(const char* stage) { return {*this, stage}; }
  /// In the order of the work; what belongs to no stage comes last.
  std::vector<StageTime> times();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr const char* kOther = "other";
  bool is_own() const { return std::this_thread::get_id() == owner_; }
  void switch_to(const char* next);
  std::thread::id owner_ = std::this_thread::get_id();
  const char* now_in_ = kOther;
  Clock::time_point since_ = Clock::now();
  std::vector<StageTime> spent_;
};

/// A recording whose reads are a stage.
class TimedSource : public FrameSource {
 public:
  /// Keeps references.
  TimedSource(FrameSource& source, StageClock& clock) : source_(source), clock_(clock) {
    info_ = source.info();
  }
  using FrameSource::read;
  void read(std::int64_t index, const Rect& window, Picture& picture) override {
    const auto timed = clock_.enter("reading and decoding");
    source_.read(index, window, picture);
  }

 private:
  FrameSource& source_;
  StageClock& clock_;
};

}  // namespace tribotrack::vision
