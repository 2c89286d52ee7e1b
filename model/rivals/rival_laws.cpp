#include "model/rival_laws.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tribotrack::model {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr long kMaxSteps = 2'000'000;

/// x, y, u_x, u_y
using State = Eigen::Vector4d;

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
    const Eigen::Vector2d ahead = s_.drive.acceleration(0), behind = s_.drive.acceleration(std::numbers::pi);
    pull_ = 0.5 * (ahead + behind);
    by_cos_ = ahead - pull_;
    by_sin_ = s_.drive.acceleration(0.5 * std::numbers::pi) - pull_;
  }

  /// Eq. (5)'s acceleration by the platform and its tilt, by one sine and cosine.
  Eigen::Vector2d drive(double t) const {
    const double wt = s_.start_phase + s_.drive.angular_frequency * t, c = std::cos(wt), s = std::sin(wt);
    return pull_ + c * by_cos_ + s * by_sin_;
  }
  /// What friction takes from the speed |u| at t, m/s^2; `middle` lies in the same segment.
  double deceleration(double t, double speed, double middle) const {
    const double fading = speed / (0.25 * speed_);
    const double more = law_.stribeck != 0 ? law_.stribeck * std::exp(-fading * fading) : 0;
    return mu(t, speed, middle) * s_.drive.gravity * (1 + more) + law_.viscous * speed;
  }
  State slope(double t, const State& q, double middle) const {
    const Eigen::Vector2d u = q.tail<2>(), d = drive(t);
    const double speed = u.norm();
    const Eigen::Vector2d along = speed > 0 ? Eigen::Vector2d(u / speed) : Eigen::Vector2d(d.normalized());
    State k;
    k << u, d - deceleration(t, speed, middle) * along;
    return k;
  }
  bool holds(double t, double middle) const {
    return drive(t).norm() <= (1 + law_.static_friction) * deceleration(t, 0, middle);
  }
  /// Where mu jumps or bends, then the end.
  std::vector<double> stations() const {
    std::vector<double> times;
    const double w = s_.drive.angular_frequency, end = s_.end_time();
    const double opens = first_edge(), closes = opens + s_.friction.pulse_width;
    for (const double edge : {opens, opens + law_.rise * w, closes, closes + law_.rise * w})
      for (double n = std::floor((s_.start_phase - edge) / kTurn);; ++n) {
        const double t = (edge + n * kTurn - s_.start_phase) / w;
        if (t >= end) break;
        if (t > 0) times.push_back(t);
      }
    times.push_back(end);
    std::sort(times.begin(), times.end());
    return times;
  }

 private:
  /// wt at which the first ramp begins.
  double first_edge() const {
    return s_.friction.phase + s_.friction.lag - 0.5 * s_.drive.angular_frequency * law_.rise;
  }
  double mu(double t, double speed, double middle) const {
    const double w = s_.drive.angular_frequency, width = s_.friction.pulse_width;
    const double at_middle = s_.start_phase + w * middle - first_edge();
    const double into = at_middle - kTurn * std::floor(at_middle / kTurn);
    const bool opened = into < width;
    const double reduced = s_.friction.reduced * (1 + law_.mu2_speed * speed / speed_);
    const double now = opened ? reduced : s_.friction.nominal;
    if (!(law_.rise > 0) || !(width > 0)) return now;
    const double since = (into - (opened ? 0 : width)) / w;  // of the segment's middle after its edge
    if (since >= law_.rise) return now;
    const double share = std::clamp((since + t - middle) / law_.rise, 0.0, 1.0);
    const double before = opened ? s_.friction.nominal : reduced;
    return before + share * (now - before);
  }

  const Scenario& s_;
  RivalLaw law_;
  double speed_ = 0;                        ///< m/s, of the platform
  Eigen::Vector2d pull_, by_cos_, by_sin_;  ///< m/s^2
};

class Integration {
 public:
  Integration(const Scenario& scenario, const RivalLaw& law, double tolerance) : f_(scenario, law) {
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
      middle_ = (t_ + station) / 2;
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
    while (t_ < station && f_.holds(t_, middle_)) {
      double low = t_, high = std::min(t_ + scan_, station);
      if (f_.holds(high, middle_)) {
        t_ = high;
        continue;
      }
      while (high - low > 1e-14 * station) {
        const double between = (low + high) / 2;
        (f_.holds(between, middle_) ? low : high) = between;
      }
      t_ = high;
    }
  }

  /// Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", table II.5.2.
  void slide(double station) {
    double h = std::min(h_ > 0 ? h_ : first_step_, station - t_);
    State k1 = slope(0, q_);
    while (t_ < station) {
      if (++steps_ > kMaxSteps) throw InvalidParameter("a rival friction law needs too many steps");
      const bool ends = t_ + h >= station || station - t_ - h < 1e-3 * h;
      if (ends) h = station - t_;
      const State k2 = slope(h / 5, q_ + h / 5 * k1);
      const State k3 = slope(3 * h / 10, q_ + h * (3. / 40 * k1 + 9. / 40 * k2));
      const State k4 = slope(4 * h / 5, q_ + h * (44. / 45 * k1 - 56. / 15 * k2 + 32. / 9 * k3));
      const State k5 = slope(8 * h / 9, q_ + h * (19372. / 6561 * k1 - 25360. / 2187 * k2 +
                                                  64448. / 6561 * k3 - 212. / 729 * k4));
      const State k6 = slope(h, q_ + h * (9017. / 3168 * k1 - 355. / 33 * k2 + 46732. / 5247 * k3 +
                                          49. / 176 * k4 - 5103. / 18656 * k5));
      const State next =
          q_ + h * (35. / 384 * k1 + 500. / 1113 * k3 + 125. / 192 * k4 - 2187. / 6784 * k5 + 11. / 84 * k6);
      const State k7 = slope(h, next);
      const State error = h * (71. / 57600 * k1 - 71. / 16695 * k3 + 71. / 1920 * k4 - 17253. / 339200 * k5 +
                               22. / 525 * k6 - 1. / 40 * k7);
      const double size = error.cwiseQuotient(absolute_).cwiseAbs().maxCoeff();
      const double factor = size > 0 ? 0.9 * std::pow(size, -0.2) : 5;
      if (!(size <= 1)) {
        h *= std::isfinite(size) ? std::clamp(factor, 0.1, 0.9) : 0.1;
        continue;
      }
      const Eigen::Vector2d before = q_.tail<2>();
      q_ = next;
      t_ = ends ? station : t_ + h;
      k1 = k7;
      if (!ends) h_ = h;
      h *= std::clamp(factor, 0.2, 5.0);
      // The witness of a stop: the velocity has turned round or is all but gone, and friction holds.
      const Eigen::Vector2d u = q_.tail<2>();
      if ((before.dot(u) <= 0 || u.norm() < stop_speed_) && f_.holds(t_, middle_)) {
        q_.tail<2>().setZero();
        return;
      }
    }
  }

  State slope(double after, const State& q) const { return f_.slope(t_ + after, q, middle_); }

  Equation f_;
  State q_, absolute_;
  double t_ = 0, middle_ = 0, h_ = 0, first_step_ = 0, stop_speed_ = 0, scan_ = 0;
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
