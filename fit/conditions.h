// The conditions of a campaign: given and measured values combined, with the errors that all runs share and
// those of each run (JCGM 100:2008, sections 4 and 5).
//
//   std::vector<RunEvidence> runs;                             // a run each: given, seen, scale, gate
//   const Conditions found = pool(runs, shared, as_they_are);  // value in, value out
//   if (!found.slips.empty()) refuse(found.slips.front());
//   scenario.drive = found.runs[k].drive;                      // and own errors, for each run
//   put_into(problem, found);                                  // Problem::conditions, Problem::prior
//
// The model. One platform moved under all runs: A, A_y, w, epsilon are one quantity q each. Run k is given
// g_k with an sd (0: exact), and its mark shows m_k:
//   m_k = q_k (1 + c) + e_k,   sd(e_k) = s_k the run's own,   sd(c) = u_c common to all runs,
// in proportion to what is given, so that runs commanded to different amplitudes are pooled as well:
//   x_k = m_k / g_k, own sd s_k / g_k;   of epsilon x_k = m_k - g_k, and what is relative below is in rad.
// Averaging does not reduce what all share. For lengths, with a_k the share of the amplitude that
// compression may have removed, b_k what an unknown exposure hides, u_k the sd of the run's scale and l
// that of the true length by which scales in the picture were measured (the part's diameter, the side of a
// tag):
//   s_k^2 = sd(m_k)^2 - (a_k^2 + b_k^2) m_k^2  [+ (u_k^2 - l^2) m_k^2 where each run has a scale of its own],
//   u_c^2 = <a>^2 + <b>^2 + <u>^2 [else <l>^2] + parallax^2,   <> the mean over the runs;
// of w u_c is the camera's clock, of epsilon 0.
//
// One quantity? The mean is weighted by its sds and compared with its scatter (fit/pooling.h):
//   x = sum w_k x_k / W,  w_k = (g_k / s_k)^2,  W = sum w_k,  chi2 = sum w_k (x_k - x)^2,
//   p = P(chi2 of n - 1 degrees of freedom > chi2),
// sd(g_k)^2 added to s_k^2 where the value is the run's own. Below p = 1e-3 the runs differ: a run without
// a given value keeps its own measured one, with its own error s_k. Each run's w then goes with the phase at
// its start, cov(w, wt_0) = (t_0 - t_middle) s_k^2.
//
// Which value? Given exactly: that. Given with an sd: the mean of 1 with the variance (sd(g)/g)^2 and x with
// 1/W + u_c^2, weighted by their inverses. Given none: x. Measured and given differ by
//   d = (x - 1) / (1/W + u_c^2 + (sd(g)/g)^2)^(1/2):
// a finding beyond 3; a slip of the pen where a run is off by more than a fifth (of a quarter turn) as well.
//
// Shared or own? What is given for one run errs for that run alone; what is given for all, or pooled over
// all, is one error of all. Of a mean in which the measured value has the weight r > 1/2 it is
//   u^2 = ((1 - r) sd(g)/g)^2 + r^2 / W,
// and the parts of u_c stand beside it as errors of their own, for the budget to tell apart; of one that is
// mostly given it is the mean's sd. So the fit's unknown conditions are, relative or in rad, independent:
//   A        u(A); where A_y is a quantity of its own, u^2 = u(A)^2 + u(A_y)^2: u / 2 of their geometric mean
//            and u of their ratio. Beside it, where A was measured: <a>, <b>, parallax.
//   w, epsilon, tilts, slope of inclines   as they are.
//   g        its own; and 2 t of a clock whose seconds are too long by the share t: where w is measured by it
//            all is, but g. Where w is given in true seconds displacements are read too late: t of scale.
//   scale    <u>: its part l, and the radius or the tag as seen; parallax, unless the part's own diameter at
//            its top is the measure.
//   phase reference   <coder's delay>; and the angle of the camera against the reference sensor's axis, where
//            phi counts from the sensor in all runs (in some: an own error of phi of these).
// An error known before the experiment is the prior of a fitted parameter; one measured in the same tracks
// is not, since the fit measures it again. What has no sd is in no interval and is listed as taken as
// exact.
//
// Nothing typed is exact. A value given without an sd has that of its last digit or of usual practice
// (SharedEvidence::assumed). It is pooled and included like any other and named in its errors (is_assumed),
// but it is no prior of a fitted parameter, since nobody said that it is known. The same holds for A_y/A =
// 1, epsilon and the start if nothing shows them; the phase of a start that was not seen is unknown.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fit/gate_timing.h"
#include "fit/measurement.h"
#include "fit/problem.h"
#include "model/drive.h"
#include "model/scenario.h"

namespace tribotrack::fit {

/// What a campaign may give, with an sd or exactly. A platform's mark shows the first four as well.
enum class Source {
  amplitude,
  amplitude_y,
  angular_frequency,
  phase_shift,
  gravity,
  tilt_x,
  tilt_y,
  slope,
  phi,
  dtau,
  sensor_axis,  ///< angle of the camera's x against the axis from which the reference sensor counts phi
  frame_rate,
  scale,
  calibration,  ///< of the camera: a scale with its sd
  diameter,     ///< of the part, by which scales in the picture are set
  tag,          ///< side of a tag, likewise
  start_phase,  ///< of runs that start at rest
  friction_law  ///< the paper's: mu1 and mu2 are numbers, the gate's edges sharp
};

const char* to_string(Source source);  ///< "amplitude_mm", "xi_axis_rad", ... as in campaigns

/// A value that a campaign gives. An sd of 0: exact; of a timing beside a measured one: not counted.
struct GivenValue {
  Estimate value;
  bool of_run = false;  ///< for this run alone, with an error of its own
};

/// The scale by which a run's lengths were measured.
struct SeenScale {
  double mm_per_px = 0;
  double relative_sd = 0;
  Source by = Source::scale;  ///< diameter and tag: each recording shows the length
};

/// One run, as given and as its recording shows it. SI; empty where there is none.
struct RunEvidence {
  bool driven = true;                                                                ///< false: a free slide
  std::optional<GivenValue> amplitude, amplitude_y, angular_frequency, phase_shift;  ///< no A_y: it is A
  Estimate phi, dtau;                                                                ///< as commanded
  std::optional<Estimate> phase_at_zero, start_phase, slope;                         ///< slope: of an incline

  std::optional<PlatformMotion> seen;             ///< the platform's motion
  double start_time = 0;                          ///< s, of the first frame
  double start = 0;                               ///< wt there, by what is seen or given
  bool start_assumed = true;                      ///< the recording does not tell it
  bool from_rest = true;                          ///< its motion depends on wt there
  double coder_attenuation = 0, coder_delay = 0;  ///< upper bounds, of what is seen: relative, rad
  std::optional<GateTiming> gate;
  bool gate_by_camera = false;     ///< phi counts from what is seen, else from the sensor as a commanded one
  std::optional<SeenScale> scale;  ///< of a track
  std::optional<Estimate> diameter;  ///< of the part by that scale, without its sd
};

/// What is given of all runs. An sd of 0: exact.
struct SharedEvidence {
  std::string seen_by = "marker";    ///< what shows the platform's motion
  std::optional<Estimate> diameter;  ///< m
  Source scale = Source::scale;      ///< of runs not scaled by the diameter: that, a calibration or a tag
  double length_sd = 0;              ///< of diameter or tag, relative
  double parallax_sd = 0;            ///< of 1 - height/distance, relative
  std::optional<double> clock_sd;    ///< of the frame rate given, relative; empty: the recordings' own
  double gravity_sd = 0;             ///< relative
  double tilt_x_sd = 0, tilt_y_sd = 0, sensor_axis_sd = 0;  ///< rad
  /// Where none is given or seen: of A_y/A, relative; of epsilon and the start, rad.
  double amplitude_ratio_sd = 0, phase_shift_sd = 0, start_phase_sd = 0;
  bool law_is_exact = true;          ///< else friction may depart from the paper's law by the usual amounts
  std::vector<Source> assumed;       ///< whose sds were not given
  std::vector<FitParameter> fitted;  ///< not taken as exact
};

/// sd of an angle of which nothing is known.
inline const double kUnknownAngle = std::numbers::pi / std::sqrt(3.0);

/// Whether an error with this `from` is a default that nobody gave.
bool is_assumed(std::string_view from);

/// Phi, dtau, phase at the start, rad.
struct Timing {
  double phi = 0, dtau = 0, start_phase = 0;
  OwnErrors own;  ///< their joint covariance
};

/// Measured if the recording shows them, else as given. A phi that counts from the camera shares the error
/// of the platform's phase. A value given with an sd is combined with the measured one by weight, except a
/// phi of the sensor with one of the camera, and a start with what is seen.
Timing settle_timing(const RunEvidence& run);

/// Given and measured differ by more than this share, of an angle in quarter turns: a slip.
inline constexpr double kSlipShare = 0.2;
/// Difference, in its sd, beyond which they contradict each other.
inline constexpr double kContradictsBeyond = 3;

/// One quantity in all runs, SI. If runs were given different values, `given` and `used` are the first
/// one's and `measured` is in proportion.
struct PooledQuantity {
  Source quantity = Source::amplitude;
  bool implied = false;  ///< A_y, where only A is given
  std::optional<Estimate> given;
  std::optional<Estimate> measured;        ///< of all runs that show it; sd with all its errors
  std::size_t runs = 0;                    ///< that show it
  double p_value = 1;                      ///< of the scatter between the runs if they have one value
  std::optional<double> difference_in_sd;  ///< measured less given, over the sd of both
  bool contradicted() const { return difference_in_sd && std::abs(*difference_in_sd) > kContradictsBeyond; }

  enum class From { given_exactly, given, given_and_measured, measured, each_its_own };
  Estimate used;
  From from = From::given_exactly;

  /// Runs without a given value that differ by more than chance.
  struct Scatter {
    double low = 0, high = 0;  ///< least and greatest value seen
    double chi2 = 0, p_value = 1;
    std::size_t runs = 0;
  };
  std::optional<Scatter> scatter = std::nullopt;

  // How it enters a fit.
  double shared_sd = 0;           ///< common to all runs: relative, of an angle rad; 0: exact, or own errors
  bool exact = false;             ///< a run takes a given value as exact
  bool by_measurement = false;    ///< measured by the marks, with the errors that all measurements share
  bool known_beforehand = false;  ///< given with an sd, for all runs
  bool assumed = false;           ///< which is a default
};

/// An error that all runs share. Relative for A, w, g and scale, else SI.
struct SharedError {
  FitParameter quantity = FitParameter::amplitude;
  double sd = 0;
  std::string from;               ///< Condition::from
  bool known_beforehand = false;  ///< independent of these runs: a prior of the quantity if it is fitted
};

/// Given and measured values contradict each other.
struct Slip {
  Source quantity = Source::amplitude;
  std::size_t run = 0;  ///< the first that is off
  GivenValue given;
  Estimate seen;            ///< there
  std::size_t runs = 1;     ///< all that show it, or this one
  bool everywhere = false;  ///< in all that show it
};

/// A run under its conditions.
struct RunConditions {
  model::Drive drive;
  OwnErrors own;
  bool amplitude_from_track = false;  ///< A was measured in the same picture
};

struct Conditions {
  std::vector<PooledQuantity> quantities;  ///< given or seen
  std::vector<SharedError> errors;
  std::vector<Source> taken_as_exact;  ///< given, or by default, without an sd
  std::vector<RunConditions> runs;
  std::vector<Slip> slips;
  bool sensor_axis_not_used = false;  ///< its sd was given, but phi counts from the camera in every run
  std::string seen_by;                ///< SharedEvidence::seen_by
  const PooledQuantity* find(Source quantity) const;
  /// Where the value used came from: "marker, 14 runs", "campaign, taken as exact".
  std::string from(const PooledQuantity& quantity) const;
};

/// `start`: the runs as they stand, by their timing; what is neither given nor seen stays.
Conditions pool(std::span<const RunEvidence> runs, const SharedEvidence& shared,
                std::vector<RunConditions> start);

/// Each shared error as a condition or the prior of what is fitted. The problem's runs and `free` are there.
void put_into(Problem& problem, const Conditions& conditions);

}  // namespace tribotrack::fit
