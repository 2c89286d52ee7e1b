#include "vision/layers/learning/light.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tribotrack::vision {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFinest = 8, kCoarsest = 16;  ///< px between nodes
constexpr double kNodesAcross = 20;            ///< a disc, unless they come too close
constexpr double kFarOff = 25, kStrange = 5;   ///< sd: what is further off is not light, before and after
constexpr double kPriorShare = 0.3;            ///< sd of l, and of h in the disc's level
constexpr double kPriorBend = 0.05;            ///< likewise of second differences from node to node
constexpr double kHiddenSd = 4;                ///< what is seen there is something else
constexpr float kHiddenShare = 0.3F;           ///< of the frames: it stands
constexpr float kFewestSeen = 4;               ///< frames that tell
constexpr int kHiddenEdge = 3;                 ///< px about it that are half covered
constexpr double kRing = 6;                    ///< px of moving ground about the rim that are looked at
constexpr double kLeastGain = 0.2;

/// Cubic B-spline: the four nodes about a place t past the second of them.
std::array<double, 4> cubic_weights(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * s * s + 3 * s * s * s) / 6,
          t * t * t / 6};
}

/// The pictures of the layers over a window of whole pixels about a frame's centre.
struct Seen {
  int left = 0, top = 0, size = 0;
  std::vector<float> level, disc, disc_x, disc_y, share, share_x, share_y, ground, ground_x, ground_y, known,
      turn;
  Seen(const KeptWindow& w, double reach) {
    const int whole = static_cast<int>(std::ceil(reach));
    left = static_cast<int>(std::lround(w.state.centre.x)) - whole;
    top = static_cast<int>(std::lround(w.state.centre.y)) - whole;
    size = 2 * whole + 1;
    for (auto* v : {&level, &disc, &disc_x, &disc_y, &share, &share_x, &share_y, &ground, &ground_x,
                    &ground_y, &known, &turn})
      v->resize(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    as_seen(w, left - w.x, top - w.y, size, size, level.data());
  }
};

}  // namespace

LightLearning::LightLearning(const LayeredDisc& disc, const GroundPicture& ground, const NoiseLaw& noise,
                             const StaticIllumination& light, bool first, double frames_of_moving_ground)
    : disc_(disc),
      ground_(ground),
      noise_(noise),
      light_(light),
      cut_(first ? kFarOff : kStrange),
      ground_moves_(frames_of_moving_ground > 0),
      texture_variance_(frames_of_moving_ground * ground.unseen_variance()),
      share_(disc.share()),
      standing_(disc.at(0)),
      seen_(light.region().width, light.region().height),
      strange_(light.region().width, light.region().height) {
  const Rect& region = light.region();
  spacing_ = std::clamp(2 * disc.rim().outer() / kNodesAcross, kFinest, kCoarsest);
  across_ = static_cast<int>(region.width / spacing_) + 4;
  down_ = static_cast<int>(region.height / spacing_) + 4;
  for (int i = 0; i < std::max(region.width, region.height); ++i) {
    const double t = i / spacing_;
    first_.push_back(static_cast<int>(t));
    for (const double weight : cubic_weights(t - std::floor(t))) weights_.push_back(weight);
  }
  const auto unknowns = 2 * static_cast<Index>(across_) * down_;
  normal_ = MatrixXd::Zero(unknowns, unknowns);
  right_ = VectorXd::Zero(unknowns);
}

void LightLearning::add(const KeptWindow& w) {
  const LayeredState& s = w.state;
  const double inner = disc_.rim().inner(), outer = disc_.rim().outer();
  const double reach = outer + (ground_moves_ ? kRing : 0);
  Seen at(w, reach);
  const double left = at.left - s.centre.x + disc_.half(), top = at.top - s.centre.y + disc_.half();
  const bool turns = disc_.turning();
  if (turns) {
    Picture slope;
    standing_ = QuinticSpline(disc_.at(s.theta, &slope));
    QuinticSpline(slope).sample_window(left, top, at.size, at.size, at.turn.data(), nullptr, nullptr);
  }
  standing_.sample_window(left, top, at.size, at.size, at.disc.data(), at.disc_x.data(), at.disc_y.data());
  share_.sample_window(left, top, at.size, at.size, at.share.data(), at.share_x.data(), at.share_y.data());
  ground_.sample(at.left - s.ground.x, at.top - s.ground.y, at.size, at.size, at.ground.data(),
                 at.known.data(), at.ground_x.data(), at.ground_y.data());

  // Whole pixels of the region that are in the window, and the nodes about them.
  const Rect& region = light_.region();
  const int x0 = std::max({at.left, w.x, region.x});
  const int y0 = std::max({at.top, w.y, region.y});
  const int x1 = std::min({at.left + at.size, w.x + w.picture.width(), region.x + region.width});
  const int y1 = std::min({at.top + at.size, w.y + w.picture.height(), region.y + region.height});
  if (x1 <= x0 || y1 <= y0) return;
  const auto first_of = [&](int pixel) { return first_[static_cast<std::size_t>(pixel)]; };
  const int i0 = first_of(x0 - region.x), j0 = first_of(y0 - region.y);
  const int nx = first_of(x1 - 1 - region.x) - i0 + 4, ny = first_of(y1 - 1 - region.y) - j0 + 4;
  const Index nodes = static_cast<Index>(nx) * ny;
  using Eight = Eigen::Matrix<double, 8, 1>;
  using EightByEight = Eigen::Matrix<double, 8, 8>;
  MatrixXd own = MatrixXd::Zero(2 * nodes, 2 * nodes), mixed = MatrixXd::Zero(2 * nodes, 8);
  EightByEight frame = EightByEight::Zero();

  const Rect& places = ground_.region();
  const int ground_x = static_cast<int>(std::lround(-s.ground.x)) - places.x;
  const int ground_y = static_cast<int>(std::lround(-s.ground.y)) - places.y;
  for (int y = y0; y < y1; ++y) {
    EightByEight squares = EightByEight::Zero(), crossed = EightByEight::Zero();
    const int row = y - region.y;
    for (int x = x0; x < x1; ++x) {
      const int column = x - region.x;
      const double u = x - s.centre.x, v = y - s.centre.y, rho_squared = u * u + v * v;
      const auto k = static_cast<std::size_t>(y - at.top) * static_cast<std::size_t>(at.size) +
                     static_cast<std::size_t>(x - at.left);
      const bool on_disc = rho_squared < inner * inner;
      const bool beside = rho_squared >= outer * outer;
      if (rho_squared < reach * reach && (on_disc || ground_moves_ || at.known[k] > 0)) {
        if (beside) {
          at.share[k] = 1;
          at.disc[k] = at.disc_x[k] = at.disc_y[k] = at.share_x[k] = at.share_y[k] = at.turn[k] = 0;
        }
        if (ground_moves_) {
          at.ground[k] = static_cast<float>(ground_.mean());
          at.ground_x[k] = at.ground_y[k] = 0;
        }

        const double gain = light_.gain().at(column, row), offset = light_.offset().at(column, row);
        const double seen = gain * static_cast<double>(at.level[k]) + offset;
        const double shine = s.gain * (1 + s.slope_x * u + s.slope_y * v);
        const double share = at.share[k], below = at.ground[k];
        const double through =
            share * below + disc_.blend() * static_cast<double>(at.share_x[k] * at.ground_x[k] +
                                                                at.share_y[k] * at.ground_y[k]);
        const double model = shine * at.disc[k] + s.ground_gain * through;
        const double under = s.ground_gain * share * gain;
        const int gx = x + ground_x, gy = y + ground_y;
        const bool within = gx >= 0 && gy >= 0 && gx < places.width && gy < places.height;
        const double unsure = on_disc         ? 0
                              : ground_moves_ ? texture_variance_
                              : within        ? static_cast<double>(ground_.variance().at(gx, gy))
                                              : ground_.unseen_variance();
        const double variance = noise_.at(gain * model + offset) + under * under * unsure;
        const double off = seen - gain * model - offset;
        const double deviation = off * off / variance;
        if (share < 0.5) {
          seen_.at(column, row) += 1;
          strange_.at(column, row) += deviation > kHiddenSd * kHiddenSd ? 1.0F : 0.0F;
        }
        if (!StaticIllumination::unseen(w.picture.at(x - w.x, y - w.y)) && deviation < cut_ * cut_) {
          Eight light, unknown;
          for (int n = 0; n < 4; ++n) light(4 + n) = weight_at(column, n);
          light.head<4>() = model * light.tail<4>();
          const double disc = at.disc[k];
          unknown << -gain * (shine * at.disc_x[k] + s.ground_gain * below * at.share_x[k]),
              -gain * (shine * at.disc_y[k] + s.ground_gain * below * at.share_y[k]), gain * disc,
              gain * disc * u, gain * disc * v, gain * through,
              turns ? gain * shine * static_cast<double>(at.turn[k]) : 0, seen - model;
          const double weight = 1 / variance;
          squares.noalias() += weight * light * light.transpose();
          crossed.noalias() += weight * light * unknown.transpose();
          frame.noalias() += weight * unknown * unknown.transpose();
        }
      }
      if (x + 1 < x1 && first_of(column + 1) == first_of(column)) continue;
      // The row's sums over a cell of the nodes.
      const int i = first_of(column) - i0, j = first_of(row) - j0;
      for (int a = 0; a < 4; ++a) {
        const double wa = weight_at(row, a);
        const Index at_a = static_cast<Index>(j + a) * nx + i;
        mixed.middleRows<4>(at_a) += wa * crossed.topRows<4>();
        mixed.middleRows<4>(nodes + at_a) += wa * crossed.bottomRows<4>();
        for (int b = 0; b < 4; ++b) {
          const double both = wa * weight_at(row, b);
          const Index at_b = static_cast<Index>(j + b) * nx + i;
          own.block<4, 4>(at_a, at_b) += both * squares.topLeftCorner<4, 4>();
          own.block<4, 4>(nodes + at_a, at_b) += both * squares.bottomLeftCorner<4, 4>();
          own.block<4, 4>(at_a, nodes + at_b) += both * squares.topRightCorner<4, 4>();
          own.block<4, 4>(nodes + at_a, nodes + at_b) += both * squares.bottomRightCorner<4, 4>();
        }
      }
      squares.setZero();
      crossed.setZero();
    }
  }
  // The frame's own unknowns are eliminated.
  const Index n = turns ? 7 : 6;
  MatrixXd inner_normal = frame.topLeftCorner(n, n);
  inner_normal.diagonal() *= 1 + 1e-9;
  inner_normal.diagonal().array() += 1e-12;
  const MatrixXd lean = inner_normal.ldlt().solve(mixed.leftCols(n).transpose());
  own.noalias() -= mixed.leftCols(n) * lean;
  const VectorXd right = mixed.col(7) - lean.transpose() * frame.col(7).head(n);
  Lean out;
  out.of = lean.topRows<2>();
  const int all = across_ * down_;
  for (const int half : {0, all})
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) out.nodes.push_back(half + (j0 + j) * across_ + i0 + i);
  for (Index b = 0; b < 2 * nodes; ++b) {
    const int to = out.nodes[static_cast<std::size_t>(b)];
    right_(to) += right(b);
    for (Index a = 0; a < 2 * nodes; ++a) normal_(out.nodes[static_cast<std::size_t>(a)], to) += own(a, b);
  }
  leans_.push_back(std::move(out));
}

/// l and h are held to 0, and to be straight from node to node.
void LightLearning::add_prior(double level) {
  const int all = across_ * down_;
  for (const auto& [first, unit] : {std::pair{0, 1.0}, std::pair{all, level}}) {
    const double held = 1 / std::pow(kPriorShare * unit, 2), straight = 1 / std::pow(kPriorBend * unit, 2);
    for (int k = 0; k < all; ++k) normal_(first + k, first + k) += held;
    const auto second = [&](int a, int b, int c) {
      const std::array<std::pair<int, double>, 3> of{{{first + a, 1}, {first + b, -2}, {first + c, 1}}};
      for (const auto& [p, wp] : of)
        for (const auto& [q, wq] : of) normal_(p, q) += straight * wp * wq;
    };
    for (int j = 0; j < down_; ++j)
      for (int i = 0; i < across_; ++i) {
        const int k = j * across_ + i;
        if (i > 0 && i + 1 < across_) second(k - 1, k, k + 1);
        if (j > 0 && j + 1 < down_) second(k - across_, k, k + across_);
      }
  }
}

void LightLearning::draw(const VectorXd& coefficients, StaticIllumination& light) const {
  const Index all = static_cast<Index>(across_) * down_;
  const Rect& region = light.region();
  for (int y = 0; y < region.height; ++y) {
    VectorXd row_gain = VectorXd::Zero(across_), row_offset = VectorXd::Zero(across_);
    for (int k = 0; k < 4; ++k) {
      const Index node = static_cast<Index>(first_[static_cast<std::size_t>(y)] + k) * across_;
      row_gain += weight_at(y, k) * coefficients.segment(node, across_);
      row_offset += weight_at(y, k) * coefficients.segment(all + node, across_);
    }
    for (int x = 0; x < region.width; ++x) {
      double gain = 1, offset = 0;
      for (int k = 0; k < 4; ++k) {
        gain += weight_at(x, k) * row_gain(first_[static_cast<std::size_t>(x)] + k);
        offset += weight_at(x, k) * row_offset(first_[static_cast<std::size_t>(x)] + k);
      }
      light.gain().at(x, y) = static_cast<float>(std::max(kLeastGain, gain));
      light.offset().at(x, y) = static_cast<float>(offset);
    }
  }
}

/// Where most frames show something else than the disc, in patches.
void LightLearning::hide(StaticIllumination& light) const {
  const int width = seen_.width(), height = seen_.height();
  const auto strange = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < width && y < height && seen_.at(x, y) >= kFewestSeen &&
           strange_.at(x, y) > kHiddenShare * seen_.at(x, y);
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!strange(x, y)) continue;
      int together = -1;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u) together += strange(u, v);
      if (together < 2) continue;
      for (int v = std::max(0, y - kHiddenEdge); v <= std::min(height - 1, y + kHiddenEdge); ++v)
        for (int u = std::max(0, x - kHiddenEdge); u <= std::min(width - 1, x + kHiddenEdge); ++u)
          if (std::hypot(u - x, v - y) <= kHiddenEdge) light.hidden().at(u, v) = 1;
    }
}

LightLearning::Learnt LightLearning::solve() {
  double level = 0, pixels = 0;
  const Picture shown = disc_.at(0);
  for (int y = 0; y < shown.height(); ++y)
    for (int x = 0; x < shown.width(); ++x)
      if (std::hypot(x - disc_.half(), y - disc_.half()) < disc_.rim().inner()) {
        level += shown.at(x, y);
        ++pixels;
      }
  level = std::max(1.0, level / std::max(1.0, pixels));
  add_prior(level);
  Learnt out{StaticIllumination(light_.region(), light_.top()), {}};
  const Eigen::LLT<MatrixXd> factor(normal_);
  if (factor.info() != Eigen::Success) return out;
  draw(factor.solve(right_), out.light);
  if (cut_ < kFarOff) hide(out.light);
  // What is not known of the light moves the windows; what moves all of them alike does not matter.
  const auto windows = static_cast<Index>(leans_.size());
  MatrixXd lean = MatrixXd::Zero(normal_.rows(), 2 * windows);
  for (Index k = 0; k < windows; ++k) {
    const Lean& l = leans_[static_cast<std::size_t>(k)];
    for (Index n = 0; n < l.of.cols(); ++n)
      lean.block<1, 2>(l.nodes[static_cast<std::size_t>(n)], 2 * k) = l.of.col(n).transpose();
  }
  MatrixXd mean = MatrixXd::Zero(normal_.rows(), 2);
  for (Index k = 0; k < windows; ++k) mean += lean.middleCols<2>(2 * k) / static_cast<double>(windows);
  for (Index k = 0; k < windows; ++k) lean.middleCols<2>(2 * k) -= mean;
  factor.matrixL().solveInPlace(lean);
  for (Index k = 0; k < windows; ++k)
    out.covariance.push_back(lean.middleCols<2>(2 * k).transpose() * lean.middleCols<2>(2 * k));
  return out;
}

}  // namespace tribotrack::vision
