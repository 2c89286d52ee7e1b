#include "fit/slides/one_by_one.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

#include "fit/residuals/free_slide.h"
#include "fit/tools/thresholds.h"
#include "fit/tools/track_errors.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

/// The problem of one slide: its mu1, all else as given. A tilt or scale that is fitted too is as all runs
/// together have it.
Problem problem_of_one(const Problem& problem, const TrajectoryRun& run,
                       const std::map<FitParameter, double>& together) {
  Problem alone;
  alone.free = {FitParameter::mu1};
  alone.fixed = problem.fixed;
  alone.fixed.erase(FitParameter::mu1);
  for (const auto& [parameter, value] : together) alone.fixed[parameter] = value;
  alone.start = problem.start;
  std::erase_if(alone.start, [](const auto& entry) { return entry.first != FitParameter::mu1; });
  alone.trajectory_runs = {run};
  return alone;
}

/// What all runs together say of the parameters that a slide depends on beside mu1.
std::map<FitParameter, double> fitted_together(const Problem& problem, const FitAlone& fit_alone) {
  std::map<FitParameter, double> values;
  const auto of_slides = [](FitParameter p) {
    return p == FitParameter::tilt_x || p == FitParameter::tilt_y || p == FitParameter::scale;
  };
  if (std::none_of(problem.free.begin(), problem.free.end(), of_slides)) return values;
  for (const ParameterEstimate& p : fit_alone(problem, true).parameters)
    if (of_slides(p.parameter)) values[p.parameter] = p.estimate;
  return values;
}

/// Spin and friction in turn: each changes the other little, so that a few rounds settle both.
FitResult fit_with_spin(Problem& alone, const FitAlone& fit_alone) {
  constexpr int kRounds = 12;
  constexpr double kSettled = 0.05;  // of the spin's sd
  FitResult fit = fit_alone(alone, true);
  TrajectoryRun& run = alone.trajectory_runs.front();
  for (int round = 0; run.spin && !run.track.angle.empty() && round < kRounds; ++round) {
    const auto& found = fit.runs.front().nuisance;
    const Eigen::Vector2d velocity(found.at("velocity_x_mm_s"), found.at("velocity_y_mm_s"));
    const auto spin = slide_spin(run, fit.parameters.front().estimate, 1e-3 * velocity);
    if (!spin) break;
    const double moved = std::abs(spin->rate - run.spin->rate);
    run.spin = spin;
    fit = fit_alone(alone, true);
    if (moved < kSettled * spin->rate_sd()) break;
  }
  return fit;
}

/// Relative change of the slide's mu1 if its rim moved half as fast as it slides.
double change_by_half_spin(Problem alone, const SlideResult& slide, const FitAlone& fit_alone) {
  TrajectoryRun& run = alone.trajectory_runs.front();
  if (!(run.track.radius > 0)) run.track.radius = 1;  // only the rim's speed counts
  const double rate = 0.5 * slide.speed / run.track.radius, sure = 1e-4;
  run.spin = DiscSpin{rate, 0, Eigen::Vector2d(std::pow(sure * rate, 2), sure * sure).asDiagonal()};
  alone.start[FitParameter::mu1] = slide.mu1.value;
  // Scatter weighs all points alike: it hardly moves the estimate.
  return fit_alone(alone, false).parameters.front().estimate / slide.mu1.value - 1;
}

void take_result(const FitResult& fit, double spin_sd, SlideResult& slide) {
  const ParameterEstimate& mu1 = fit.parameters.front();
  const RunResult& run = fit.runs.front();
  slide.mu1 = {mu1.estimate, mu1.sd};
  slide.ci95 = mu1.ci95;
  slide.chi2 = fit.chi2;
  slide.p_value = fit.p_value;
  slide.dof = 2 * static_cast<int>(run.points) - 5;
  slide.scatter = fit.scatter;
  slide.points = run.points;
  slide.speed = 1e-3 * run.nuisance.at("initial_speed_mm_s");
  slide.stop_time = run.nuisance.at("stop_time_s");
  if (!slide.spin_seen) return;
  slide.spin = {run.nuisance.at("spin_rad_s"), spin_sd};
  const double per_rate = run.nuisance.at("spin_ratio") / std::abs(slide.spin.value);
  slide.spin_ratio = {run.nuisance.at("spin_ratio"), per_rate * slide.spin.sd};
}

SlideResiduals residuals_of(const FitResult& fit) {
  const auto& slide = fit.runs.front().slide;
  SlideResiduals residuals{slide.time, slide.measured};
  for (std::size_t k = 0; k < residuals.value.size(); ++k) residuals.value[k] -= slide.modelled[k];
  return residuals;
}

}  // namespace

void fit_one_by_one(Problem& problem, const FitAlone& fit_alone, int threads,
                    std::vector<SlideResult>& slides) {
  if (slides.empty()) return;
  const std::map<FitParameter, double> together = fitted_together(problem, fit_alone);
  std::vector<TrajectoryRun*> runs;
  for (TrajectoryRun& run : problem.trajectory_runs)
    if (run.free_slide) runs.push_back(&run);
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    Problem alone = problem_of_one(problem, *runs[i], together);
    FitResult fit = fit_with_spin(alone, fit_alone);
    // Where the slide contradicts what the tracker tells of its errors, their division into slow and white is
    // not to be trusted either: their size is, and how long they last is found from the residuals.
    if (fit.p_value < kSurprise && !runs[i]->track.slow.empty()) {
      runs[i]->track.slow.clear();
      alone.trajectory_runs.front().track.slow.clear();
      fit = fit_with_spin(alone, fit_alone);
    } else if (const auto shown = shown_errors(runs[i]->track, residuals_of(fit))) {
      take_errors(*shown, runs[i]->track);
      take_errors(*shown, alone.trajectory_runs.front().track);
      slides[i].shown_slow = shown->slow;
      fit = fit_with_spin(alone, fit_alone);
    }
    runs[i]->spin = alone.trajectory_runs.front().spin;
    if (slides[i].spin_seen)
      slides[i].bearing = {std::exp(runs[i]->spin->bearing),
                           std::exp(runs[i]->spin->bearing) * std::sqrt(runs[i]->spin->covariance(1, 1))};
    take_result(fit, runs[i]->spin ? runs[i]->spin->rate_sd() : 0, slides[i]);
    const auto& frame = runs[i]->track.frame;
    if (const auto onset = fit.runs.front().nuisance.find("onset_frame");
        onset != fit.runs.front().nuisance.end())
      slides[i].first_frame = static_cast<std::int64_t>(onset->second);
    if (!frame.empty()) slides[i].last_frame = frame.back();
    if (!slides[i].spin_seen && runs[i]->slope == 0)
      slides[i].change_by_half_spin = change_by_half_spin(alone, slides[i], fit_alone);
  });
}

std::optional<ViscousSlides> fit_viscous(const Problem& problem, const FitAlone& fit_alone, int threads,
                                         const std::vector<SlideResult>& constant) {
  if (!problem.fits(FitParameter::mu1) ||
      std::ranges::none_of(constant, [](const SlideResult& slide) { return slide.p_value < kSurprise; }))
    return std::nullopt;
  const std::map<FitParameter, double> together = fitted_together(problem, fit_alone);
  std::vector<const TrajectoryRun*> runs;
  for (const TrajectoryRun& run : problem.trajectory_runs)
    if (run.free_slide) runs.push_back(&run);
  ViscousSlides found{constant, {}, {}};
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    SlideResult& slide = found.slides[i];
    Problem alone = problem_of_one(problem, *runs[i], together);
    alone.free.push_back(FitParameter::viscous);
    const FitResult fit = fit_alone(alone, true);
    take_result(fit, slide.spin.sd, slide);
    slide.viscous = {fit.parameters.back().estimate, fit.parameters.back().sd};
  });
  std::vector<Estimate> mu1, viscous;
  for (const SlideResult& slide : found.slides) {
    if (!(slide.mu1.sd > 0) || !std::isfinite(slide.mu1.sd) || !std::isfinite(slide.viscous->sd)) continue;
    mu1.push_back(slide.mu1);
    viscous.push_back(*slide.viscous);
  }
  if (mu1.size() < 2) return std::nullopt;
  found.mu1 = between_slides(mu1);
  found.viscous = between_slides(viscous);
  return found;
}

std::optional<BetweenSlides> compare_slides(const Problem& problem, const std::vector<SlideResult>& slides) {
  if (slides.size() < 2 || !problem.fits(FitParameter::mu1)) return std::nullopt;
  std::vector<Estimate> mu1;
  for (const SlideResult& slide : slides)
    if (slide.mu1.sd > 0 && std::isfinite(slide.mu1.sd)) mu1.push_back(slide.mu1);
  if (mu1.size() < 2) return std::nullopt;
  return between_slides(mu1);
}

namespace {

/// A blow to a part slower than this share of its speed afterwards is what sets it sliding.
constexpr double kFromRest = 0.2;

Blow blow_of(const TrackTable& track, const FoundBlow& found) {
  Blow blow;
  blow.frame = found.row < track.frame.size() ? track.frame[found.row] : static_cast<std::int64_t>(found.row);
  blow.time = track.time[found.row];
  blow.speed_before = found.before.norm();
  blow.speed_after = found.after.norm();
  blow.jump = (found.after - found.before).norm();
  return blow;
}

}  // namespace

std::vector<SlideResult> prepare_slides(Problem& problem) {
  std::vector<SlideResult> slides;
  for (TrajectoryRun& run : problem.trajectory_runs) {
    if (!run.free_slide) continue;
    SlideResult slide;
    slide.run = run.name;
    slide.slope = run.slope;
    const std::vector<FoundBlow> found = find_blows(run.track);
    const Stretch stretch = longest_clean_stretch(run.track, found);
    for (const FoundBlow& blow : found) {
      const bool starts_it = blow.row <= stretch.first && blow.row + 1 >= stretch.first &&
                             blow.before.norm() < kFromRest * blow.after.norm();
      if (!starts_it) slide.blows.push_back(blow_of(run.track, blow));
    }
    run.track = part_of(run.track, stretch.first, stretch.last);
    if (run.slope != 0) {
      const Stretch sliding = sliding_stretch(run.track);
      run.track = part_of(run.track, sliding.first, sliding.last);
      if (run.downhill.isZero()) run.downhill = downhill_of(run);
    } else if (!run.spin) {
      run.spin = first_slide_spin(run);
    }
    slide.spin_seen = run.spin.has_value();
    slides.push_back(slide);
  }
  return slides;
}

Stretch sliding_stretch(const TrackTable& track) {
  const std::vector<double> speeds = smoothed_speeds(track);
  const Motion motion = find_motion(speeds);
  if (speeds.empty() || !motion.gains_speed()) return {0, track.time.size()};
  // Of points: a window's speed is that of its middle, and all of the fastest window slides.
  return {motion.first + kSpeedWindow, motion.fastest + 2 * kSpeedWindow + 1};
}

Eigen::Vector2d downhill_of(const TrajectoryRun& run) {
  const Eigen::Vector2d way = run.track.position.back() - run.track.position.front();
  const double length = way.norm();
  if (!(length > 0)) throw DataError("Free slide '" + run.name + "': the part does not move.");
  return run.slope > 0 ? Eigen::Vector2d(way / length) : Eigen::Vector2d(-way / length);
}

}  // namespace tribotrack::fit::internal
