#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/minimum/multi_start.h"
#include "fit/tools/dense.h"
#include "fit/tools/parameters.h"
#include "fit/uncertainty/profile.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Interval limits(const Unknowns& unknowns, FitParameter parameter, double value) {
  const auto within = [&](double half) { return Interval{value - half, value + half}; };
  const Sort sort = facts(parameter).sort;
  if (parameter == FitParameter::mu1) return {1e-3 * value, std::max(10.0, 10 * value)};
  if (parameter == FitParameter::mu2) return {1e-5, std::max(10.0, 10 * value)};
  if (parameter == FitParameter::delay) return within(std::numbers::pi / unknowns.reference_frequency());
  if (sort == Sort::phase) return within(std::numbers::pi);
  if (sort == Sort::tilt) return within(0.5);
  return {0.1 * value, 10 * value};
}

/// A point this much below a minimum is a better one.
constexpr double kLower = 0.01;

/// Chi^2 to a share of what ends are known to, see OneSide::search().
MinimiseOptions held_at(const Residuals& residuals, Eigen::Index parameter) {
  return {.held = parameter,
          .decrement = residuals.linear_in_conditions() ? 0.01 : 1e-3,
          .max_iterations = 15,
          .patient = false};
}

/// From a point inside a region to where the constrained minimum leaves it.
class OneSide {
  struct Point {
    Eigen::VectorXd z;
    double height;  ///< root of the rise of chi^2, less the border's
  };

 public:
  /// `level`: chi^2 at the border; `inside` lies below it.
  OneSide(const Residuals& residuals, const Minimum& inside, Eigen::Index parameter, double lowest,
          double level, bool settled)
      : residuals_(residuals),
        settled_(settled),
        inside_(inside),
        index_(parameter),
        axis_(residuals.unknowns().transform(parameter)),
        by_value_(residuals.unknowns().parameter(parameter) == FitParameter::mu2),
        lowest_(lowest),
        level_(level) {
    const Unknowns& unknowns = residuals.unknowns();
    const Linearised by_z = inside.at.scaled(unknowns.slopes(inside.z));
    const Eigen::MatrixXd covariance = shared_covariance(by_z, 1e-14);
    const double variance = covariance(index_, index_);
    sd_ = variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : 1;
    along_ = by_z.following(variance > 0 ? Eigen::VectorXd(covariance.col(index_) / variance)
                                         : Eigen::VectorXd(Eigen::VectorXd::Unit(unknowns.common(), index_)),
                            unknowns.size());
    if (!by_value_) return;
    const double slope = axis_.slope(inside.z(index_));
    sd_ *= slope;
    along_ /= slope;
  }

  /// z where the profile crosses; nullopt when it does not before `limit`. Of a model that is linear in the
  /// conditions first where it was made linear; then where each point lies, which costs more.
  std::optional<double> cross(double limit) {
    const Point inside{inside_.z, height(inside_.chi2)};
    std::optional<double> end = search(inside, limit, std::max(-inside.height, 0.1 * target()) * sd_);
    // The points of tracks tell conditions so well that these are linear as far as any end is.
    const bool tracks = residuals_.unknowns().problem().has_driven_tracks();
    if (!end || better || tracks || !residuals_.linear_in_conditions()) return end;
    points.resize(known_);
    bent_ = false;
    end = search(inside, limit, std::abs(place(*end) - place(inside.z(index_))), Linear::at_each_point);
    known_ = points.size();
    return end && bent_ ? no_nearer_than_covariance(*end, limit) : end;
  }

  std::optional<Minimum> better;
  std::vector<ProfilePoint> points;  ///< by the parameter's value

 private:
  /// Where a model is made linear in the conditions; one that is not linear in them is the same everywhere.
  enum class Linear { as_it_is, at_each_point };

  /// From a point inside, with a first step.
  std::optional<double> search(Point inside, double limit, double step, Linear where = Linear::as_it_is) {
    const double direction = limit > inside.z(index_) ? 1 : -1, end = place(limit);
    // What is looked at again where each point lies may be rough.
    const bool fine = !residuals_.linear_in_conditions();
    const double enough = (where == Linear::at_each_point ? 0.03 : fine ? 0.004 : 0.15) * target();
    const double narrow = (fine ? 0.005 : 0.03) * std::max(sd_, 1e-12);
    std::optional<Point> outside;
    double least_outside = kInfinity;  ///< height
    for (int i = 0; i < (fine ? kMostPoints : kMostPoints / 2); ++i) {
      const double here = place(inside.z(index_));
      double next = 0;
      if (outside) {  // regula falsi on sqrt(rise), kept off the ends
        const double share = std::clamp(-inside.height / (outside->height - inside.height), 0.05, 0.95);
        next = here + share * (place(outside->z(index_)) - here);
      } else {
        next = here + direction * step;
        if (direction * (next - end) > 0) next = end;
      }
      const auto point = at(next, outside && outside->height < -inside.height ? *outside : inside, where);
      if (better) return std::nullopt;
      if (!point) {  // the model cannot be evaluated there
        step *= 0.5;
        if (outside || step < 1e-3 * sd_) return std::nullopt;
        continue;
      }
      bent_ |= point->height < inside.height - kBend * target() ||
               point->height > least_outside + kBend * target();
      if (std::abs(point->height) < enough) return point->z(index_);
      if (point->height < 0) {
        if (next == end) return std::nullopt;
        const double gained = (point->height - inside.height) / std::abs(next - here);
        inside = *point;
        if (!outside)
          step = std::clamp(gained > 0 ? -1.05 * point->height / gained : 4 * step, 0.05 * step, 4 * step);
      } else {
        outside = *point;
        least_outside = std::min(least_outside, point->height);
      }
      // Kinks of chi^2 tell an end no better.
      if (outside && std::abs(place(outside->z(index_)) - place(inside.z(index_))) < narrow)
        return point->z(index_);
    }
    return outside ? std::optional(from_place(0.5 * (place(inside.z(index_)) + place(outside->z(index_)))))
                   : std::nullopt;
  }

  /// Where a profile falls on its way out, kinks of chi^2 have hidden valleys from it.
  double no_nearer_than_covariance(double end, double limit) const {
    const double first = place(inside_.z(index_)), border = place(limit);
    const double direction = border > first ? 1 : -1;
    const double way = std::max(direction * (place(end) - first), std::sqrt(level_ - inside_.chi2) * sd_);
    return from_place(first + direction * std::min(way, direction * (border - first)));
  }

  static constexpr int kMostPoints = 12;
  static constexpr double kBend = 0.05;  ///< of the height: more than integration and descents leave open

  double target() const { return std::sqrt(level_ - lowest_); }
  double height(double chi2) const { return std::sqrt(std::max(0.0, chi2 - lowest_)) - target(); }

  /// Where a z lies on the axis along which the search steps: the value itself of mu2, whose z a small value
  /// stretches without end.
  double place(double z) const { return by_value_ ? axis_.value(z) : z; }
  double from_place(double place) const { return by_value_ ? axis_.z(place) : place; }

  std::optional<Point> at(double next, const Point& neighbour, Linear where) {
    const Unknowns& unknowns = residuals_.unknowns();
    Eigen::VectorXd start = neighbour.z + along_ * (next - place(neighbour.z(index_)));
    start(index_) = from_place(next);
    std::optional<Residuals> there;
    if (where == Linear::at_each_point && !there.emplace(residuals_).linearise(unknowns.values(start)))
      return std::nullopt;
    const Minimum held = minimise(there ? *there : residuals_, start, held_at(residuals_, index_));
    if (!std::isfinite(held.chi2)) return std::nullopt;
    // Beyond mu2 = mu1 pulses would raise friction: no part of the model.
    if (!admissible(unknowns, held.z)) return Point{held.z, target()};
    if (held.chi2 < lowest_ - kLower && !settled_) better = held;
    points.push_back({axis_.value(held.z(index_)), std::max(0.0, held.chi2 - lowest_)});
    return Point{held.z, height(held.chi2)};
  }

  const Residuals& residuals_;
  bool settled_;  ///< what lies below the minimum is none of the full model
  const Minimum& inside_;
  Eigen::Index index_;
  const Transform& axis_;
  bool by_value_;
  double lowest_, level_, sd_ = 1;
  bool bent_ = false;      ///< the profile fell on its way out
  std::size_t known_ = 0;  ///< points of the side that was looked at before
  Eigen::VectorXd along_;
};

/// Pieces less apart than this share of all of them are one: ends are known no better.
constexpr double kGap = 0.01;

/// Regions on one parameter's axis, in its z.
class Pieces {
 public:
  /// `turn`: the axis is a circle of this length; 0: a line.
  explicit Pieces(double turn) : turn_(turn) {}

  void add(Interval piece, double middle) {
    if (turn_ > 0 && std::isfinite(piece.low) && std::isfinite(piece.high)) {
      const double by = turn_ * std::round((middle - 0.5 * (piece.low + piece.high)) / turn_);
      piece = {piece.low + by, piece.high + by};
    }
    pieces_.push_back(piece);
    std::sort(pieces_.begin(), pieces_.end(), [](const auto& a, const auto& b) { return a.low < b.low; });
    std::vector<Interval> merged;
    for (const Interval& next : pieces_) {
      const double reach = merged.empty() ? 0 : next.high - merged.front().low;
      if (!merged.empty() && next.low <= merged.back().high + (std::isfinite(reach) ? kGap * reach : 0))
        merged.back().high = std::max(merged.back().high, next.high);
      else
        merged.push_back(next);
    }
    // On a circle the last may reach into the first.
    if (turn_ > 0 && merged.size() > 1 && merged.back().high - turn_ >= merged.front().low) {
      merged.front().low = std::min(merged.front().low, merged.back().low - turn_);
      merged.pop_back();
    }
    pieces_ = merged;
  }
  bool holds(double z) const {
    return std::any_of(pieces_.begin(), pieces_.end(), [&](const Interval& piece) {
      const double by = turn_ > 0 && std::isfinite(piece.low)
                            ? turn_ * std::round((0.5 * (piece.low + piece.high) - z) / turn_)
                            : 0;
      return piece.low <= z + by && z + by <= piece.high;
    });
  }
  bool open() const {
    return std::any_of(pieces_.begin(), pieces_.end(), [&](const Interval& piece) {
      return turn_ > 0 ? !(piece.high - piece.low < turn_)
                       : piece.low == -kInfinity && piece.high == kInfinity;
    });
  }
  const std::vector<Interval>& all() const { return pieces_; }

 private:
  double turn_;
  std::vector<Interval> pieces_;
};

/// Whole range, in one piece: nothing is excluded.
Profile open_profile() {
  return {{{-kInfinity, kInfinity}}, {}, std::nullopt};
}

/// `settled`: a point below the minimum counts as at it.
class ParameterProfile {
 public:
  ParameterProfile(const Residuals& residuals, const std::vector<Minimum>& minima, Eigen::Index parameter,
                   double rise, bool settled)
      : residuals_(residuals),
        settled_(settled),
        unknowns_(residuals.unknowns()),
        best_(minima.front()),
        index_(parameter),
        name_(unknowns_.parameter(parameter)),
        level_(best_.chi2 + rise),
        pieces_(turn()) {
    const Transform& transform = unknowns_.transform(parameter);
    const Interval range = limits(unknowns_, name_, transform.value(best_.z(parameter)));
    limits_ = {transform.z(range.low), transform.z(range.high)};
    // A valley in an interval already found that begins higher by 1 hardly reaches beyond it.
    for (const Minimum& minimum : minima)
      if (minimum.chi2 < level_ && !(pieces_.holds(minimum.z(parameter)) && minimum.chi2 > best_.chi2 + 1))
        follow(minimum);
  }

  /// Is there more, where no piece lies? The lowest point of the sample in each of a number of classes of the
  /// parameter is where to look, where the classes beside it are no lower.
  void look_between(const std::vector<ScreenedPoint>& sample) {
    const double rise = level_ - best_.chi2, near = refinable(residuals_);
    std::vector<const ScreenedPoint*> lowest_of(kClasses, nullptr);
    std::vector<double> floor(kClasses, kInfinity);
    double low = kInfinity, high = -kInfinity, lowest = kInfinity;
    for (const ScreenedPoint& point : sample) {
      if (!std::isfinite(point.chi2)) continue;
      low = std::min(low, point.z(index_));
      high = std::max(high, point.z(index_));
      lowest = std::min(lowest, point.chi2);
    }
    if (!(high > low)) return;
    for (const ScreenedPoint& point : sample) {
      if (!(point.chi2 < lowest + near)) continue;
      const double share = (point.z(index_) - low) / (high - low);
      const std::size_t k = std::min(kClasses - 1, static_cast<std::size_t>(share * kClasses));
      floor[k] = std::min(floor[k], point.chi2);
      if (pieces_.holds(point.z(index_))) continue;
      const ScreenedPoint*& here = lowest_of[k];
      if (!here || point.chi2 < here->chi2) here = &point;
    }
    for (std::size_t k = 0; k < kClasses; ++k) {
      const ScreenedPoint* here = lowest_of[k];
      if (better || pieces_.open()) return;
      // The bottom of a valley lies no higher than what is beside it.
      if (!here || here->chi2 > floor[k == 0 ? k : k - 1] ||
          here->chi2 > floor[std::min(k + 1, kClasses - 1)])
        continue;
      if (pieces_.holds(here->z(index_))) continue;
      if (!promises(here->z, rise)) continue;
      const Minimum held = minimise(residuals_, here->z, held_at(residuals_, index_));
      if (!(held.chi2 < level_) || !admissible(unknowns_, held.z)) continue;
      if (held.chi2 < best_.chi2 - kLower && !settled_) {
        better = held;
        return;
      }
      follow(linearised(residuals_, held));
    }
  }

  Profile result() const {
    if (better) return {{}, {}, better};
    if (pieces_.all().empty() || (turn() > 0 && pieces_.open())) return open_profile();
    const Transform& transform = unknowns_.transform(index_);
    const bool may_be_zero = name_ == FitParameter::mu1 || name_ == FitParameter::mu2;
    Profile profile;
    profile.points = points_;
    std::ranges::sort(profile.points, {}, &ProfilePoint::value);
    for (const Interval& piece : pieces_.all())
      profile.pieces.push_back({std::isfinite(piece.low) ? transform.value(piece.low)
                                : may_be_zero            ? 0
                                                         : -kInfinity,
                                std::isfinite(piece.high) ? transform.value(piece.high) : kInfinity});
    return profile;
  }

  std::optional<Minimum> better;

 private:
  double turn() const {
    // The z of a delay is w delay.
    return name_ == FitParameter::lag || name_ == FitParameter::delay ? 2 * std::numbers::pi : 0;
  }

  void follow(const Minimum& from) {
    if (better) return;
    // On a circle the limits move with the start.
    const double by = turn() > 0 ? from.z(index_) - best_.z(index_) : 0;
    OneSide side(residuals_, from, index_, best_.chi2, level_, settled_);
    const auto low = side.cross(limits_.low + by);
    const auto high = side.better ? std::nullopt : side.cross(limits_.high + by);
    better = side.better;
    side.points.push_back(
        {unknowns_.transform(index_).value(from.z(index_)), std::max(0.0, from.chi2 - best_.chi2)});
    points_.insert(points_.end(), side.points.begin(), side.points.end());
    pieces_.add({low.value_or(-kInfinity), high.value_or(kInfinity)}, best_.z(index_));
  }

  /// Would chi^2 come near the border if the model were linear?
  bool promises(const Eigen::VectorXd& z, double rise) const {
    const auto at = residuals_.at(unknowns_.values(z));
    return at && at->chi2() - newton_decrement(*at, index_) < level_ + kFar * rise;
  }

  static constexpr std::size_t kClasses = 40;
  static constexpr double kFar = 5;  ///< rises: a linear forecast from a point of the sample is no better
  const Residuals& residuals_;
  bool settled_;
  const Unknowns& unknowns_;
  const Minimum& best_;
  Eigen::Index index_;
  FitParameter name_;
  double level_;
  Interval limits_;
  Pieces pieces_;
  std::vector<ProfilePoint> points_;
};

}  // namespace

std::vector<Profile> profiles(const Residuals& residuals, std::vector<Minimum>& minima,
                              const std::vector<ScreenedPoint>& sample, const std::vector<bool>& open,
                              const std::vector<double>& rises, int threads) {
  const auto n = static_cast<std::size_t>(residuals.unknowns().reported());
  Residuals rough = residuals;
  rough.set_tolerance(residuals.tolerance_for(0.01, 1e-6));
  bool settled = false;
  for (int restart = 0;; ++restart) {
    std::vector<Profile> found(n, open_profile());
    parallel_for(n, threads, [&](std::size_t i) {
      if (open[i]) return;
      ParameterProfile profile(rough, minima, static_cast<Eigen::Index>(i), rises[i], settled);
      profile.look_between(sample);
      found[i] = profile.result();
    });
    const Profile* better = nullptr;
    for (const Profile& one : found)
      if (one.better && (!better || one.better->chi2 < better->better->chi2)) better = &one;
    if (!better) return found;
    Residuals there = residuals;
    Minimum lower = linearised(there, minimise_linearised(there, better->better->z));
    settled = restart == 2 || !(lower.chi2 < minima.front().chi2);
    if (settled) continue;
    minima.insert(minima.begin(), std::move(lower));
    there.set_tolerance(residuals.tolerance_for(0.01, 1e-6));
    rough = std::move(there);
  }
}

}  // namespace tribotrack::fit::internal
