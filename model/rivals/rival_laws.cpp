#include "model/rival_laws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "model/rivals/rival_step.h"

namespace tribotrack::model {
namespace {

using namespace internal;

static_assert(kMostRivalLaws == kRivalLanes);

constexpr double kTurn = 2 * std::numbers::pi;
constexpr long kMaxSteps = 2'000'000;
constexpr double kMaxTurns = 1e5;

/// The laws, and the platform that they share.
class Equation {
 public:
  Equation(const Scenario& scenario, std::span<const RivalLaw> laws) : s_(scenario) {
    const double w = s_.drive.angular_frequency, width = s_.friction.pulse_width;
    const double platform = std::max(s_.drive.amplitude, s_.drive.amplitude_y) * w;
    speed_ = platform > 0 ? platform : s_.initial_velocity.norm();
    start_ = std::remainder(s_.start_phase, kTurn);
    first_edge_ = std::remainder(s_.friction.phase + s_.friction.lag, kTurn);
    for (int lane = 0; lane < kRivalLanes; ++lane) {
      laws_[lane] = laws[static_cast<std::size_t>(lane) < laws.size() ? static_cast<std::size_t>(lane) : 0];
      const RivalLaw& law = laws_[lane];
      const bool too_long = law.rise < 0 || law.rise * w > std::min(width, kTurn - width);
      const double all = law.stribeck + law.fading + law.viscous + law.rise + law.mu2_speed +
                         law.static_friction + law.mu1 + law.mu2;
      if (!std::isfinite(all) || !(law.stribeck > -1) || law.fading < 0 || (too_long && width > 0))
        throw InvalidParameter(
            "a rival law of friction is out of range: stribeck = " + std::to_string(law.stribeck) +
            ", fading = " + std::to_string(law.fading) + " m/s, rise = " + std::to_string(law.rise) + " s");
      const double fading = law.fading > 0 ? law.fading : 0.25 * speed_, z = speed_ / fading;
      const double g = s_.drive.gravity, fast = 1 + law.stribeck * std::exp(-z * z);
      if (s_.friction.nominal * (1 + law.mu1) * g * fast + law.viscous * speed_ < 0 ||
          s_.friction.reduced * (1 + law.mu2) * (1 + law.mu2_speed) * g * fast + law.viscous * speed_ < 0)
        throw InvalidParameter(
            "a rival law of friction pushes the part: viscous = " + std::to_string(law.viscous) +
            " 1/s, mu2_speed = " + std::to_string(law.mu2_speed));
      friction_.stribeck.lane[lane] = law.stribeck;
      friction_.fading.lane[lane] = fading;
      friction_.viscous.lane[lane] = law.viscous + s_.viscous;
    }
    if (!(s_.end_time() * w < kTurn * kMaxTurns))
      throw InvalidParameter("a rival friction law needs too many steps");
    const Eigen::Vector2d ahead = s_.drive.acceleration(0), behind = s_.drive.acceleration(std::numbers::pi);
    pull_ = 0.5 * (ahead + behind);
    by_cos_ = ahead - pull_;
    by_sin_ = s_.drive.acceleration(0.5 * std::numbers::pi) - pull_;
  }

  RivalDrive drive(double t) const {
    const double w = s_.drive.angular_frequency, wt = start_ + w * t, c = std::cos(wt), s = std::sin(wt);
    const Eigen::Vector2d d = pull_ + c * by_cos_ + s * by_sin_, rate = w * (c * by_sin_ - s * by_cos_);
    return {d.x(), d.y(), rate.x(), rate.y()};
  }
  /// At the t of the segment.
  RivalFriction friction(double t) const {
    RivalFriction there = friction_;
    for (int lane = 0; lane < kRivalLanes; ++lane) {
      there.level.lane[lane] += there.by_time.lane[lane] * (t - segment_begins_);
      there.by_speed.lane[lane] += there.by_speed_time.lane[lane] * (t - segment_begins_);
    }
    return there;
  }
  /// Whether friction at rest, at the t of the segment, is a match for the drive.
  bool holds(int lane, double t, double drive) const {
    const double level = friction_.level.lane[lane] + friction_.by_time.lane[lane] * (t - segment_begins_);
    return drive <= (1 + laws_[lane].static_friction) * (1 + laws_[lane].stribeck) * level;
  }
  /// The segment between two stations is the one that all of these ask about.
  void enter(double begin, double end) {
    const double w = s_.drive.angular_frequency, width = s_.friction.pulse_width, g = s_.drive.gravity;
    const double middle = (begin + end) / 2;
    segment_begins_ = begin;
    for (int lane = 0; lane < kRivalLanes; ++lane) {
      const RivalLaw& law = laws_[lane];
      const double since_first = start_ + w * middle - first_edge_ + 0.5 * w * law.rise;
      const double into = since_first - kTurn * std::floor(since_first / kTurn);
      const bool open = into < width;
      const double since = (into - (open ? 0 : width)) / w;  // its edge
      const double reduced = s_.friction.reduced * (1 + law.mu2) * g,
                   nominal = s_.friction.nominal * (1 + law.mu1) * g;
      const double by_speed = reduced * law.mu2_speed / speed_;
      // On a ramp the share of what comes after the edge grows with time.
      const bool on_ramp = width > 0 && since < law.rise;
      const double rate = on_ramp ? 1 / law.rise : 0,
                   share = on_ramp ? 1 - (since - middle + begin) * rate : 0;
      const double before = open ? nominal : reduced, after = open ? reduced : nominal;
      const double before_by_speed = open ? 0 : by_speed, after_by_speed = open ? by_speed : 0;
      friction_.level.lane[lane] = after + share * (before - after);
      friction_.by_time.lane[lane] = rate * (after - before);
      friction_.by_speed.lane[lane] = after_by_speed + share * (before_by_speed - after_by_speed);
      friction_.by_speed_time.lane[lane] = rate * (after_by_speed - before_by_speed);
    }
  }
  /// Where mu of any law jumps or bends, every turn's end, and the end.
  std::vector<double> stations(double turn, double end) const {
    const double w = s_.drive.angular_frequency;
    std::vector<double> times{end};
    std::set<double> edges;
    for (const RivalLaw& law : laws_)
      for (const double bend : {-0.5 * w * law.rise, 0.5 * w * law.rise})
        for (const double edge : {first_edge_, first_edge_ + s_.friction.pulse_width})
          edges.insert(edge + bend);
    for (const double edge : edges)
      for (double n = std::floor((start_ - edge) / kTurn);; ++n) {
        const double t = (edge + n * kTurn - start_) / w;
        if (t >= end) break;
        if (t > 0) times.push_back(t);
      }
    for (double t = turn; t < end; t += turn) times.push_back(t);
    std::sort(times.begin(), times.end());
    return times;
  }

 private:
  const Scenario& s_;
  std::array<RivalLaw, kRivalLanes> laws_;
  double speed_ = 0;                        ///< m/s, of the platform
  double start_ = 0;                        ///< wt at which the run begins, within a turn
  double first_edge_ = 0;                   ///< wt at which the gate opens
  Eigen::Vector2d pull_, by_cos_, by_sin_;  ///< m/s^2
  RivalFriction friction_;                  ///< where the segment begins
  double segment_begins_ = 0;               ///< s
};

class Integration {
 public:
  Integration(const Scenario& scenario, std::span<const RivalLaw> laws, double tolerance)
      : f_(scenario, laws) {
    const double platform = std::max(scenario.drive.amplitude, scenario.drive.amplitude_y);
    const double own = scenario.initial_velocity.norm();
    const double length = platform > 0 ? platform : own * scenario.end_time();
    const double speed = platform > 0 ? platform * scenario.drive.angular_frequency : own;
    in_.tolerance = tolerance;
    in_.least_position = tolerance * length;
    in_.least_speed = tolerance * speed;
    stop_speed_ = std::max(30 * tolerance, 1e-10) * speed;
    h_ = first_step_ = 1e-3 / scenario.drive.angular_frequency;
    turn_ = kTurn / scenario.drive.angular_frequency;
    std::ranges::fill(in_.from.u_x.lane, scenario.initial_velocity.x());
    std::ranges::fill(in_.from.u_y.lane, scenario.initial_velocity.y());
    std::ranges::fill(in_.moving.lane, own > 0 ? 1 : 0);
  }

  /// Rows x and y of each of the times, a column for each lane.
  Eigen::MatrixXd at(const std::vector<double>& times) {
    Eigen::MatrixXd positions(2 * times.size(), kRivalLanes);
    std::vector<Asked> asked;
    for (const double time : times) asked.push_back({time, 2 * static_cast<Eigen::Index>(asked.size())});
    see(asked, positions);
    // Turns repeat: what is left has its place in the next one, and the turns between add their way.
    for (Asked& one : asked) {
      one.turns = std::floor((one.time - t_) / turn_ + 1e-9);
      one.time -= one.turns * turn_;
    }
    std::ranges::sort(asked, {}, &Asked::time);
    see(asked, positions);
    return positions;
  }

 private:
  using Places = Eigen::Matrix<double, 2, kRivalLanes>;
  struct Asked {
    double time;
    Eigen::Index row;  ///< of x
    double turns = 0;  ///< that go before it, each by way_
  };

  static Places of_lanes(const RivalRow& x, const RivalRow& y) {
    Places result;
    result << Eigen::Map<const Eigen::RowVectorXd>(x.lane, kRivalLanes),
        Eigen::Map<const Eigen::RowVectorXd>(y.lane, kRivalLanes);
    return result;
  }
  static Places places(const RivalMotion& motion) { return of_lanes(motion.x, motion.y); }
  static Places speeds(const RivalMotion& motion) { return of_lanes(motion.u_x, motion.u_y); }

  /// Until a turn brings all velocities back to where they were; what was seen is asked no more.
  void see(std::vector<Asked>& asked, Eigen::MatrixXd& positions) {
    if (asked.empty()) return;
    auto next = asked.begin();
    const auto look = [&](double since) {
      for (; next != asked.end() && next->time <= t_; ++next)
        positions.middleRows<2>(next->row) = between(since, next->time) + next->turns * way_;
    };
    look(t_);
    RivalMotion before = in_.from;
    double next_turn = t_ + turn_ * (1 - 1e-12);
    for (const double station : f_.stations(turn_, asked.back().time)) {
      if (t_ < station) enter(station);
      while (t_ < station) {
        const double since = t_;
        step(station);
        look(since);
      }
      if (t_ < next_turn || next == asked.end()) continue;
      if (repeats(before)) {
        way_ = places(in_.from) - places(before);
        break;
      }
      before = in_.from;
      next_turn = t_ + turn_ * (1 - 1e-12);
    }
    asked.erase(asked.begin(), next);
  }

  /// In the step since then: by positions and velocities at both ends (Hermite).
  Places between(double since, double time) const {
    if (!(t_ > since)) return places(in_.from);
    const double h = t_ - since, s = (time - since) / h, left = 1 - s;
    return left * left * ((1 + 2 * s) * places(before_) + s * h * speeds(before_)) +
           s * s * ((3 - 2 * s) * places(in_.from) - left * h * speeds(in_.from));
  }

  bool repeats(const RivalMotion& before) const {
    for (int lane = 0; lane < kRivalLanes; ++lane)
      if (!(std::abs(in_.from.u_x.lane[lane] - before.u_x.lane[lane]) < in_.least_speed &&
            std::abs(in_.from.u_y.lane[lane] - before.u_y.lane[lane]) < in_.least_speed))
        return false;
    return true;
  }

  /// A segment: lanes at rest will join in where the drive exceeds their friction.
  void enter(double station) {
    f_.enter(t_, station);
    for (int lane = 0; lane < kRivalLanes; ++lane)
      if (rests(lane)) released_[lane] = release(lane, station);
    in_.drive[0] = f_.drive(t_);
  }

  /// A step of its motion, or the whole time in which all rest.
  void step(double station) {
    double until = station;
    bool all_rest = true;
    for (int lane = 0; lane < kRivalLanes; ++lane) {
      if (rests(lane) && released_[lane] <= t_) {
        in_.moving.lane[lane] = 1;
        h_ = std::min(h_, first_step_);  // from rest the direction jumps, whatever the others do
      }
      all_rest &= rests(lane);
      if (rests(lane)) until = std::min(until, released_[lane]);
    }
    before_ = in_.from;
    if (all_rest) {
      t_ = until;
      in_.drive[0] = f_.drive(t_);
    } else {
      advance(until);
      stop(station);
    }
  }

  bool rests(int lane) const { return in_.moving.lane[lane] == 0; }

  /// When friction no longer holds, found to rounding; the station at the latest.
  double release(int lane, double station) {
    const auto holds = [&](double t) { return f_.holds(lane, t, size_of(f_.drive(t))); };
    double low = t_;
    if (!holds(low)) return low;
    while (low < station) {
      const double high = std::min(low + turn_ / kScans, station);
      if (holds(high)) {
        low = high;
        continue;
      }
      double late = high;
      while (late - low > 1e-14 * station) {
        const double between = (low + late) / 2;
        (holds(between) ? low : late) = between;
      }
      return late;
    }
    return station;
  }
  static double size_of(const RivalDrive& drive) { return std::sqrt(drive.x * drive.x + drive.y * drive.y); }

  /// One step. A part that creeps, all but held, turns at once wherever the drive points: that is stiff, and
  /// an implicit method's.
  void advance(double until) {
    in_.friction = f_.friction(t_);
    double h = std::min(h_, until - t_);
    for (;;) {
      if (++steps_ > kMaxSteps) throw InvalidParameter("a rival friction law needs too many steps");
      const bool ends = t_ + h >= until || until - t_ - h < 1e-3 * h;
      in_.h = ends ? until - t_ : h;
      for (int i = 1; i < 5; ++i) in_.drive[i] = f_.drive(t_ + kRivalTimes[i] * in_.h);
      RivalMotion next;
      double error = 0;
      take_rival_step(in_, next, error);
      const double factor = error > 0 ? 0.9 / std::sqrt(std::sqrt(error)) : 5;
      if (error <= 1) {
        in_.from = next;
        in_.drive[0] = in_.drive[4];
        t_ = ends ? until : t_ + h;
        if (!ends) h_ = h * std::clamp(factor, 0.2, 5.0);
        return;
      }
      h = in_.h * (std::isfinite(error) ? std::clamp(factor, 0.1, 0.9) : 0.1);
    }
  }

  /// The witness of a stop: the velocity has turned round or is all but gone, and friction holds.
  void stop(double station) {
    const double drive = size_of(in_.drive[0]);
    for (int lane = 0; lane < kRivalLanes; ++lane) {
      double &x = in_.from.u_x.lane[lane], &y = in_.from.u_y.lane[lane];
      const bool turned = before_.u_x.lane[lane] * x + before_.u_y.lane[lane] * y <= 0;
      if (rests(lane) || !(turned || x * x + y * y < stop_speed_ * stop_speed_) || !f_.holds(lane, t_, drive))
        continue;
      x = y = in_.moving.lane[lane] = 0;
      released_[lane] = release(lane, station);
    }
  }

  static constexpr int kScans = 720;  ///< a turn: looks at whether the drive exceeds friction
  Equation f_;
  RivalStepInput in_;
  RivalMotion before_;
  std::array<double, kRivalLanes> released_{};  ///< s, of lanes at rest: when they will start
  double t_ = 0, h_ = 0, first_step_ = 0, turn_ = 0, stop_speed_ = 0;
  Places way_ = Places::Zero();  ///< m, of a turn that repeats
  long steps_ = 0;
};

}  // namespace

Eigen::MatrixXd rival_positions(const Scenario& scenario, const std::vector<double>& times,
                                std::span<const RivalLaw> laws, double tolerance) {
  scenario.validate();
  if (scenario.start != Start::rest)
    throw InvalidParameter("rival friction laws are integrated from rest or an initial velocity only");
  if (scenario.spin.rate != 0)
    throw InvalidParameter("rival friction laws are integrated for parts that do not spin");
  if (laws.empty() || laws.size() > kMostRivalLaws)
    throw InvalidParameter("one to eight rival laws are integrated together");
  if (times.empty() || !std::ranges::is_sorted(times) || times.front() < 0)
    throw InvalidParameter("rival friction laws need times that ascend");
  return Integration(scenario, laws, tolerance).at(times).leftCols(static_cast<Eigen::Index>(laws.size()));
}

}  // namespace tribotrack::model
