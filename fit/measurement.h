// Measurements on a single track: displacement (alpha, v) and the platform's motion, with uncertainty.
//
//   if (const auto platform = measure_platform_motion(track)) {             // the marker's circle
//     const Displacement moved = measure_displacement(track, platform->angular_frequency, 20);
//     if (moved.alpha) std::printf("alpha %g +- %g rad\n", moved.alpha->value, moved.alpha->sd);
//     std::printf("v %g +- %g m/s\n", moved.mean_velocity.value, moved.mean_velocity.sd);
//   }
#pragma once

#include <Eigen/Core>
#include <optional>
#include <stdexcept>
#include <vector>

#include "fit/track_table.h"

namespace tribotrack::fit {

/// Data that cannot be used; what() is one sentence for the user, with the remedy.
class DataError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A number and its standard deviation.
struct Estimate {
  double value = 0;
  double sd = 0;
};

/// Displacement between two interpolated points exactly N whole cycles apart, and alpha, v (paper,
/// section 2.2) from it.
struct Displacement {
  Eigen::Vector2d vector = Eigen::Vector2d::Zero();      ///< m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m^2: errors of both ends, interpolation, w
  int cycles = 0;                                        ///< N
  double duration = 0;                                   ///< s, N 2 pi / w
  /// Given as alpha and v of N whole cycles, measured elsewhere: a fit that changes w changes the duration
  /// at the same v. False: two points of a recording, `duration` apart whatever w is.
  bool given_as_velocity = false;
  std::optional<Estimate> alpha;  ///< rad in [0, 2 pi); empty below 3 sd of displacement
  Estimate mean_velocity;         ///< v, m/s
};

/// Fills alpha and mean_velocity from vector, covariance and duration.
void derive_alpha_and_v(Displacement& displacement);

/// A displacement measured elsewhere and given as alpha (rad) and v (m/s), as a vector with its covariance.
/// At v = 0 alpha has no meaning and the covariance is round. Throws DataError unless v >= 0 and both sds >
/// 0.
Displacement displacement_from_alpha_v(const Estimate& alpha, const Estimate& velocity,
                                       double angular_frequency, int cycles);

/// From the first tracked point to the point N 2 pi / w later, N = min(cycles, available), interpolated
/// between frames by a local polynomial. In the camera's frame whole cycles cancel the platform's motion, so
/// the formula is the same there. The covariance holds the noise of both points, the error of interpolating
/// (estimated by leaving out frames of the same platform phase: friction switches make the acceleration jump
/// there every cycle), and the end's shift with w. Where the end falls into a gap of lost frames longer than
/// a sixth of a cycle, N is reduced until it does not. Throws DataError when the track is shorter than one
/// cycle.
Displacement measure_displacement(const TrackTable& track, const Estimate& angular_frequency, int cycles);

/// A multiple of the drive's frequency in the platform's motion: an eccentric drive's second and third.
struct Harmonic {
  int order = 2;
  Estimate amplitude, amplitude_y;  ///< m
  /// Above its noise in x or y.
  bool seen() const { return amplitude.value > 4 * amplitude.sd || amplitude_y.value > 4 * amplitude_y.sd; }
};

/// From a row of the track on the platform is seen elsewhere, and at another time of its motion:
/// m(t + ahead) + moved in the place of m(t).
struct MotionBreak {
  std::size_t row = 0;
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();  ///< m
  double ahead = 0;                                 ///< s; of frames that are missing as many intervals
};

/// The platform's motion by a sine fit to all frames of the marker, eq. (1): xi = A cos(wt), eta = A_y cos(wt
/// + epsilon), wt = w time + phase_at_zero.
struct PlatformMotion {
  Estimate amplitude;          ///< A, m
  Estimate amplitude_y;        ///< A_y, m
  Estimate angular_frequency;  ///< w, rad/s
  Estimate phase_shift;        ///< epsilon, rad in (-pi, pi]
  Estimate phase_at_zero;      ///< rad in [0, 2 pi)
  double residual_rms = 0;     ///< m
  bool clockwise = false;      ///< sense seen with y up: sin(epsilon) > 0
  /// wt at the middle of the track, where it is known best: there it is not correlated with w.
  Estimate phase_at_middle;  ///< rad, not brought into [0, 2 pi): = phase_at_zero + w middle_time mod 2 pi
  double middle_time = 0;    ///< s
  /// dw/dt seen, rad/s^2, from the quadratic part of the phase. The other values are those of constant w.
  std::optional<Estimate> frequency_drift;
  std::vector<Harmonic> harmonics;  ///< 2 and 3, where the frames resolve them
  /// Relative, included in the sds of both amplitudes: what an unknown exposure can hide of them. All
  /// recordings of a camera share it.
  double exposure_doubt = 0;
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();  ///< m, of the circle's centre in the whole track
  /// Where the circle breaks: then amplitudes, w and phases are wrong by more than their sds.
  std::optional<MotionBreak> broken;
  bool frequency_drifts() const;  ///< the drift stands above 4 sd
};

/// The amplitude is that of the platform, not of its blurred picture: an exposure T shrinks the circle by
/// sin(wT/2) / (wT/2), which is corrected if the track states T and included in the sd if not.
///
/// The standard deviations follow the residuals where these are larger than the track's own sigma: by their
/// size, by their power near w where they are coloured, and by the part that repeats every cycle (the error
/// of a template depends on its position within the pixels and has all multiples of w alike: what is seen
/// at 4w and above is assumed at w).
///
/// nullopt without a marker, or when the marker does not move more than its noise (then the platform rests).
std::optional<PlatformMotion> measure_platform_motion(const TrackTable& track);

/// A motion of one amplitude seen through a dead band: the output follows only after a reversal by twice
/// the half width, as slow motion in compressed video does (vision/coding).
struct SeenThroughPlay {
  double attenuation = 0;  ///< share by which the amplitude of the fundamental is too small
  double delay = 0;        ///< rad
};

/// The dead band's describing function: of r = half_width / amplitude below 1
///   1 - attenuation, delay = modulus and -angle of a + i b,
///   a = (pi/2 + asin(1 - 2r) + 2 (1 - 2r) sqrt(r (1 - r))) / pi,  b = -4 r (1 - r) / pi
/// [Gelb and Vander Velde, Multiple-Input Describing Functions, 1968, appendix B]. From r = 1 on the motion
/// is not seen: attenuation 1, delay pi/2.
SeenThroughPlay seen_through_play(double amplitude, double half_width);

/// White noise of each coordinate of a track that has no standard deviations of its own.
struct PointNoise {
  Eigen::Vector2d sd;  ///< in the track's unit
  /// The variance is as good as one of so many degrees of freedom where residuals of the same points are
  /// judged by it: chi^2/dof is distributed as F(dof, this) over its mean. With nu = 2/var(ln s^2) of n
  /// points it is 1/(1/nu - 2/n): estimate and residuals go together, by what the best estimate of all has of
  /// variance, 2/n.
  double dof = 0;
};

/// From differences of order 2 to 10 over frames that follow each other evenly, of binomial(2d, d) times the
/// noise's variance. A slow motion leaves high orders alone and the jumps of its acceleration trouble few of
/// them: the median of their sizes counts. Of white noise the lowest order knows most; it is taken unless a
/// higher one lies below it by more than chance, as the covariance of both has it. Errors slower than the
/// frames do not show. nullopt from fewer than 30 such frames.
std::optional<PointNoise> point_noise(const std::vector<std::int64_t>& frames,
                                      const std::vector<Eigen::Vector2d>& positions);

/// The same measurements with the sd of the scale (relative, common to all lengths) added. For reports and
/// other programs; a fit has the scale as a parameter of its own and takes them without.
Displacement with_scale_sd(Displacement displacement, double relative_sd);
PlatformMotion with_scale_sd(PlatformMotion motion, double relative_sd);

/// The platform's motion for plots.
struct PlatformPicture {
  std::vector<Eigen::Vector2d> orbit;  ///< m, the marker about its mean, one per row of the track
  std::vector<double> phase_left;      ///< rad, by which each frame is ahead of constant w
  std::vector<Eigen::Vector2d> model;  ///< m, one whole turn of the fitted motion
};

/// A frame's remaining phase is its residual along the direction of motion, over the speed there: eq. (1) to
/// first order. Where the platform stands still for a moment (motion along one axis) it is NaN.
PlatformPicture picture_of(const TrackTable& track, const PlatformMotion& motion);

}  // namespace tribotrack::fit
