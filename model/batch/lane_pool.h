// Runs under way, of which eight at a time take a step side by side.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "model/batch/lane_run.h"
#include "model/processor/kernels.h"

namespace tribotrack::model::internal {

/// Keeps enough runs under way that nearly always one kind of step has eight of them waiting. `Run` is EndRun
/// or OrbitRun.
template <class Run, bool kNeighbours>
class LanePool {
 public:
  LanePool() : machines_(kernels().slides), runs_(kUnderWay) {
    for (std::size_t i = 0; i < kUnderWay; ++i) spare_.push_back(i);
  }

  /// `source()` gives the next run's number or nothing; `begin(run, number)` prepares it; `end(run, number,
  /// need)` takes what is done or needs the scalar integrator.
  template <class Source, class Begin, class End>
  void work(const Source& source, const Begin& begin, const End& end);
  long steps() const { return steps_; }

 private:
  static constexpr int kWidth = SlideLanes::kWidth;
  static constexpr std::size_t kUnderWay = 6 * kWidth;
  struct Slot {
    Run run;
    std::size_t number = 0;
  };
  /// The lanes of one kind of step: who sits where, and who waits.
  struct Group {
    SlideLanes lanes{};
    std::array<int, kWidth> seat;
    int seated = 0;
    std::vector<int> waiting;
    int size() const { return seated + static_cast<int>(waiting.size()); }
    Group() {
      seat.fill(-1);
      for (int lane = 0; lane < kWidth; ++lane) put(LaneState{}, lanes, lane);
    }
  };

  /// visit(place in a LaneState, row of SlideLanes) for all that a step changes.
  template <class State, class Lanes, class Visit>
  static void each_field(State& one, Lanes& all, const Visit& visit) {
    visit(one.left, all.left);
    visit(one.vx, all.vx);
    visit(one.vy, all.vy);
    visit(one.zx, all.zx);
    visit(one.zy, all.zy);
    for (int i = 0; kNeighbours && i < 2; ++i) {
      visit(one.ux[i], all.ux[i]);
      visit(one.uy[i], all.uy[i]);
      visit(one.yx[i], all.yx[i]);
      visit(one.yy[i], all.yy[i]);
    }
  }
  static void put(const LaneState& from, SlideLanes& to, int lane) {
    to.kappa[lane] = from.kappa;
    to.tolerance[lane] = from.tolerance;
    each_field(from, to, [lane](double value, double* row) { row[lane] = value; });
  }
  static void take(const SlideLanes& from, int lane, LaneState& to) {
    each_field(to, from, [lane](double& value, const double* row) { value = row[lane]; });
  }
  SlideStep step_of(int kind) const {
    const SlideSteps& steps = kind == static_cast<int>(Need::slide) ? machines_.slide : machines_.creep;
    if (kind == static_cast<int>(Need::start)) return machines_.start;
    return kNeighbours ? steps.with_neighbours : steps.alone;
  }
  int busiest() const {
    for (const Need kind : {Need::slide, Need::creep, Need::start})
      if (group_[static_cast<int>(kind)].size() >= kWidth) return static_cast<int>(kind);
    int best = 0;
    for (int kind = 1; kind < kStepKinds; ++kind)
      if (group_[kind].size() > group_[best].size()) best = kind;
    return best;
  }
  template <class End>
  void settle(int slot, Need need, const End& end);
  template <class End>
  void step(int kind, const End& end);

  SlideMachines machines_;
  std::vector<Slot> runs_;
  std::vector<std::size_t> spare_;
  Group group_[kStepKinds];
  long steps_ = 0;
};

template <class Run, bool kNeighbours>
template <class Source, class Begin, class End>
void LanePool<Run, kNeighbours>::work(const Source& source, const Begin& begin, const End& end) {
  bool more = true;
  while (true) {
    while (more && !spare_.empty()) {
      const std::optional<std::size_t> number = source();
      if (!(more = number.has_value())) break;
      const std::size_t slot = spare_.back();
      spare_.pop_back();
      runs_[slot].run = Run{};
      runs_[slot].number = *number;
      settle(static_cast<int>(slot), begin(runs_[slot].run, *number), end);
    }
    if (spare_.size() == kUnderWay) return;
    step(busiest(), end);
  }
}

/// To where it waits for what it needs.
template <class Run, bool kNeighbours>
template <class End>
void LanePool<Run, kNeighbours>::settle(int slot, Need need, const End& end) {
  Slot& s = runs_[static_cast<std::size_t>(slot)];
  if (need == Need::edge) need = s.run.pass_edge();
  if (need == Need::done || need == Need::scalar) {
    steps_ += s.run.steps;
    end(s.run, s.number, need);
    spare_.push_back(static_cast<std::size_t>(slot));
  } else {
    group_[static_cast<int>(need)].waiting.push_back(slot);
  }
}

template <class Run, bool kNeighbours>
template <class End>
void LanePool<Run, kNeighbours>::step(int kind, const End& end) {
  Group& g = group_[kind];
  for (int lane = 0; lane < kWidth && !g.waiting.empty(); ++lane) {
    if (g.seat[static_cast<std::size_t>(lane)] >= 0) continue;
    const int slot = g.waiting.back();
    g.waiting.pop_back();
    g.seat[static_cast<std::size_t>(lane)] = slot;
    ++g.seated;
    put(runs_[static_cast<std::size_t>(slot)].run.lane, g.lanes, lane);
  }
  step_of(kind)(g.lanes);
  for (int lane = 0; lane < kWidth; ++lane) {
    int& seat = g.seat[static_cast<std::size_t>(lane)];
    if (seat < 0) continue;
    Run& run = runs_[static_cast<std::size_t>(seat)].run;
    take(g.lanes, lane, run.lane);
    Need need = run.look(static_cast<Need>(kind));
    if (need == static_cast<Need>(kind)) continue;
    if (need == Need::edge) {
      need = run.pass_edge();
      if (need == static_cast<Need>(kind)) {
        put(run.lane, g.lanes, lane);
        continue;
      }
    }
    const int slot = seat;
    seat = -1;
    --g.seated;
    put(LaneState{}, g.lanes, lane);
    settle(slot, need, end);
  }
}

}  // namespace tribotrack::model::internal
