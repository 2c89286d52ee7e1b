#include "model/rival_laws.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tribotrack::model {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr long kMaxSteps = 2'000'000;
constexpr double kMaxTurns = 1e5;

/// x, y, u_x, u_y
using State = Eigen::Vector4d;

/// What friction takes from the speed |u|, m/s^2, and its derivatives by |u| and by time.
struct Deceleration {
  double value, by_speed, by_time;
};

/// The acceleration by the platform and its tilt, m/s^2, and its derivative by time.
struct Pull {
  Eigen::Vector2d value, by_time;
};

class Equation {
 public:
  Equation(const Scenario& scenario, const RivalLaw& law) : s_(scenario), law_(law) {
    const double w = s_.drive.angular_frequency, width = s_.friction.pulse_width;
    const double platform = std::max(s_.drive.amplitude, s_.drive.amplitude_y) * w;
    speed_ = platform > 0 ? platform : s_.initial_velocity.norm();
    const bool too_long = law.rise < 0 || law.rise * w > std::min(width, kTurn - width);
    const double all = law.stribeck + law.viscous + law.rise + law.mu2_speed + law.static_friction;
    if (!std::isfinite(all) || !(law.stribeck > -1) || (too_long && width > 0))
      throw InvalidParameter("a rival law of friction is out of range: stribeck = " +
                             std::to_string(law.stribeck) + ", rise = " + std::to_string(law.rise) + " s");
    for (const bool open : {false, true}) {
      open_ = open;
      if (deceleration(0, speed_).value < 0)
        throw InvalidParameter(
            "a rival law of friction pushes the part: viscous = " + std::to_string(law.viscous) +
            " 1/s, mu2_speed = " + std::to_string(law.mu2_speed));
    }
    if (!(s_.end_time() * w < kTurn * kMaxTurns))
      throw InvalidParameter("a rival friction law needs too many steps");
    const Eigen::Vector2d ahead = s_.drive.acceleration(0), behind = s_.drive.acceleration(std::numbers::pi);
    pull_ = 0.5 * (ahead + behind);
    by_cos_ = ahead - pull_;
    by_sin_ = s_.drive.acceleration(0.5 * std::numbers::pi) - pull_;
    start_ = std::remainder(s_.start_phase, kTurn);
    first_edge_ = std::remainder(s_.friction.phase + s_.friction.lag, kTurn) - 0.5 * w * law.rise;
  }

  Pull drive(double t) const {
    const double w = s_.drive.angular_frequency, wt = start_ + w * t, c = std::cos(wt), s = std::sin(wt);
    return {pull_ + c * by_cos_ + s * by_sin_, w * (c * by_sin_ - s * by_cos_)};
  }
  /// At the t of the segment.
  Deceleration deceleration(double t, double speed) const {
    const double fading = speed / (0.25 * speed_), g = s_.drive.gravity;
    const double more = law_.stribeck != 0 ? law_.stribeck * std::exp(-fading * fading) : 0;
    const Deceleration mu = friction(t, speed);
    return {mu.value * g * (1 + more) + law_.viscous * speed,
            mu.by_speed * g * (1 + more) - mu.value * g * more * 2 * fading / (0.25 * speed_) + law_.viscous,
            mu.by_time * g * (1 + more)};
  }
  Eigen::Vector2d acceleration(double t, const Eigen::Vector2d& u, const Eigen::Vector2d& drive) const {
    const double speed = u.norm();
    return drive - deceleration(t, speed).value * direction(u, speed, drive);
  }
  /// Along the motion, or where the part is about to go.
  static Eigen::Vector2d direction(const Eigen::Vector2d& u, double speed, const Eigen::Vector2d& drive) {
    return speed > 0 ? Eigen::Vector2d(u / speed) : drive.normalized();
  }
  bool holds(double t) const {
    return drive(t).value.norm() <= (1 + law_.static_friction) * deceleration(t, 0).value;
  }
  /// The segment between two stations that holds `middle` is the one that all of the following ask about.
  void enter(double middle) {
    const double w = s_.drive.angular_frequency, width = s_.friction.pulse_width;
    const double at_middle = start_ + w * middle - first_edge_;
    const double into = at_middle - kTurn * std::floor(at_middle / kTurn);
    open_ = into < width;
    const double since = (into - (open_ ? 0 : width)) / w;  // its edge
    on_ramp_ = width > 0 && since < law_.rise;
    ramp_begins_ = middle - since;
  }
  /// Where mu jumps or bends, then the end.
  std::vector<double> stations() const {
    std::vector<double> times;
    const double w = s_.drive.angular_frequency, end = s_.end_time();
    const double opens = first_edge_, closes = opens + s_.friction.pulse_width;
    for (const double edge : {opens, opens + law_.rise * w, closes, closes + law_.rise * w})
      for (double n = std::floor((start_ - edge) / kTurn);; ++n) {
        const double t = (edge + n * kTurn - start_) / w;
        if (t >= end) break;
        if (t > 0) times.push_back(t);
      }
    times.push_back(end);
    std::sort(times.begin(), times.end());
    return times;
  }

 private:
  /// mu.
  Deceleration friction(double t, double speed) const {
    const double by_speed = s_.friction.reduced * law_.mu2_speed / speed_;
    const Deceleration reduced{s_.friction.reduced + by_speed * speed, by_speed, 0};
    const Deceleration nominal{s_.friction.nominal, 0, 0};
    const Deceleration &now = open_ ? reduced : nominal, &before = open_ ? nominal : reduced;
    if (!on_ramp_) return now;
    const double share = std::clamp((t - ramp_begins_) / law_.rise, 0.0, 1.0);
    return {before.value + share * (now.value - before.value),
            before.by_speed + share * (now.by_speed - before.by_speed),
            (now.value - before.value) / law_.rise};
  }

  const Scenario& s_;
  RivalLaw law_;
  double speed_ = 0;                        ///< m/s, of the platform
  double start_ = 0;                        ///< wt at which the run begins, within a turn
  double first_edge_ = 0;                   ///< wt at which a first ramp begins
  Eigen::Vector2d pull_, by_cos_, by_sin_;  ///< m/s^2
  // Of the segment: mu2's; mu goes from one to the other, from when on, s.
  bool open_ = false, on_ramp_ = false;
  double ramp_begins_ = 0;
};

class Integration {
 public:
  Integration(const Scenario& scenario, const RivalLaw& law, double tolerance)
      : f_(scenario, law), tolerance_(tolerance) {
    const double platform = std::max(scenario.drive.amplitude, scenario.drive.amplitude_y);
    const double own = scenario.initial_velocity.norm();
    const double length = platform > 0 ? platform : own * scenario.end_time();
    const double speed = platform > 0 ? platform * scenario.drive.angular_frequency : own;
    absolute_ << tolerance * length, tolerance * length, tolerance * speed, tolerance * speed;
    stop_speed_ = std::max(30 * tolerance, 1e-10) * speed;
    first_step_ = 1e-3 / scenario.drive.angular_frequency;
    scan_ = kTurn / scenario.drive.angular_frequency / 720;
    q_ << 0, 0, scenario.initial_velocity;
  }

  /// Where the run ends. Once a turn brings the velocity back to where it was, the turns that are left repeat
  /// it.
  Eigen::Vector2d end(double turn) {
    std::vector<double> stations = f_.stations();
    const double end = stations.back();
    for (double t = turn; t < end; t += turn) stations.push_back(t);
    std::sort(stations.begin(), stations.end());
    State before = q_;
    double next_turn = turn;
    for (const double station : stations) {
      f_.enter((t_ + station) / 2);
      while (t_ < station) {
        if (q_.tail<2>().isZero(0)) rest(station);
        if (t_ < station) slide(station);
      }
      if (t_ < next_turn) continue;
      const double left = std::floor((end - t_) / turn + 1e-9);
      if (left > 0 && (q_ - before).tail<2>().cwiseAbs().maxCoeff() < absolute_(2)) {
        q_.head<2>() += left * (q_ - before).head<2>();
        t_ += left * turn;
      }
      before = q_;
      next_turn = t_ + turn * (1 - 1e-12);
    }
    return q_.head<2>();
  }

 private:
  /// At rest until the drive exceeds friction, found to rounding.
  void rest(double station) {
    while (t_ < station && f_.holds(t_)) {
      double low = t_, high = std::min(t_ + scan_, station);
      if (f_.holds(high)) {
        t_ = high;
        continue;
      }
      while (high - low > 1e-14 * station) {
        const double between = (low + high) / 2;
        (f_.holds(between) ? low : high) = between;
      }
      t_ = high;
    }
  }

  /// Until the part stops, or the station. A part that creeps, all but held, turns at once wherever the drive
  /// points: that is stiff, and an implicit method's.
  void slide(double station) {
    double h = std::min(h_ > 0 ? h_ : first_step_, station - t_);
    Pull here = f_.drive(t_);
    while (t_ < station) {
      if (++steps_ > kMaxSteps) throw InvalidParameter("a rival friction law needs too many steps");
      const bool ends = t_ + h >= station || station - t_ - h < 1e-3 * h;
      if (ends) h = station - t_;
      const auto [next, error, there] = step(h, here);
      const double size = error.cwiseQuotient(absolute_ + tolerance_ * next.cwiseAbs()).cwiseAbs().maxCoeff();
      const double factor = size > 0 ? 0.9 / std::sqrt(std::sqrt(size)) : 5;
      if (!(size <= 1)) {
        h *= std::isfinite(size) ? std::clamp(factor, 0.1, 0.9) : 0.1;
        continue;
      }
      const Eigen::Vector2d before = q_.tail<2>();
      q_ = next;
      here = there;
      t_ = ends ? station : t_ + h;
      if (!ends) h_ = h;
      h *= std::clamp(factor, 0.2, 5.0);
      // The witness of a stop: the velocity has turned round or is all but gone, and friction holds.
      const Eigen::Vector2d u = q_.tail<2>();
      if ((before.dot(u) <= 0 || u.norm() < stop_speed_) && f_.holds(t_)) {
        q_.tail<2>().setZero();
        return;
      }
    }
  }

  struct Step {
    State end, error;
    Pull drive;  ///< at the end
  };
  /// Rosenbrock's method of order 4 (3), L-stable: RODAS in Hairer, Wanner, "Solving Ordinary Differential
  /// Equations II", section IV.7.
  Step step(double h, const Pull& here) const {
    static constexpr int kStages = 6;
    static constexpr double kGamma = 0.25;
    static constexpr double kTime[kStages] = {0, 0.386, 0.21, 0.63, 1, 1};
    static constexpr double kByTime[kStages] = {0.25, -0.1043, 0.1035, -0.03620000000000023, 0, 0};
    static constexpr double kA[kStages][5] = {
        {},
        {1.544},
        {0.9466785280815826, 0.2557011698983284},
        {3.314825187068521, 2.896124015972201, 0.9986419139977817},
        {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895},
        {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1}};
    static constexpr double kC[kStages][5] = {
        {},
        {-5.6688},
        {-2.430093356833875, -0.2063599157091915},
        {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
        {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616},
        {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054}};
    // d - m(|u|) u/|u|, its derivatives by u and by time.
    const Eigen::Vector2d u = q_.tail<2>();
    const double speed = u.norm();
    const Eigen::Vector2d along = f_.direction(u, speed, here.value);
    const Deceleration m = f_.deceleration(t_, speed);
    const Eigen::Matrix2d on_it = along * along.transpose();
    Eigen::Matrix2d jacobian = -m.by_speed * on_it;
    if (speed > 0) jacobian -= m.value / speed * (Eigen::Matrix2d::Identity() - on_it);
    const Eigen::Vector2d by_time = here.by_time - m.by_time * along;
    const Eigen::Matrix2d solved = (Eigen::Matrix2d::Identity() / (h * kGamma) - jacobian).inverse();
    State stage[kStages], at = q_;
    Pull drive = here;
#pragma GCC unroll 6
    for (int i = 0; i < kStages; ++i) {
      State sum = State::Zero();
      at = q_;
#pragma GCC unroll 6
      for (int j = 0; j < i; ++j) {
        at += kA[i][j] * stage[j];
        sum += kC[i][j] * stage[j];
      }
      sum /= h;
      const Eigen::Vector2d velocity = at.tail<2>();
      if (i > 0 && kTime[i] != kTime[i - 1]) drive = f_.drive(t_ + kTime[i] * h);
      const Eigen::Vector2d rate = i == 0 ? Eigen::Vector2d(here.value - m.value * along)
                                          : f_.acceleration(t_ + kTime[i] * h, velocity, drive.value);
      stage[i].tail<2>() = solved * (rate + sum.tail<2>() + h * kByTime[i] * by_time);
      stage[i].head<2>() = h * kGamma * (velocity + sum.head<2>() + stage[i].tail<2>());
    }
    return {at + stage[kStages - 1], stage[kStages - 1], drive};
  }

  Equation f_;
  double tolerance_;
  State q_, absolute_;
  double t_ = 0, h_ = 0, first_step_ = 0, stop_speed_ = 0, scan_ = 0;
  long steps_ = 0;
};

}  // namespace

Eigen::Vector2d rival_displacement(const Scenario& scenario, const RivalLaw& law, double tolerance) {
  scenario.validate();
  if (scenario.start != Start::rest)
    throw InvalidParameter("rival friction laws are integrated from rest or an initial velocity only");
  if (scenario.spin.rate != 0)
    throw InvalidParameter("rival friction laws are integrated for parts that do not spin");
  return Integration(scenario, law, tolerance).end(kTurn / scenario.drive.angular_frequency);
}

}  // namespace tribotrack::model
