#include "vision/layers/registration/slow_error.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr double kMostPairs = 3e6;  ///< of pulls at one place that are summed: more places are thinned out

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;

struct PullOfWindow {
  std::uint32_t window = 0;
  float x = 0, y = 0;
};

/// All windows' pulls, place after place.
struct PullsByPlace {
  std::vector<std::size_t> first;  ///< of each place, and the end
  std::vector<PullOfWindow> pulls;

  PullsByPlace(const std::vector<GroundLean>& windows, std::size_t places) : first(places + 1, 0) {
    for (const GroundLean& w : windows)
      for (const GroundLean::Pull& p : w.pulls) ++first[p.place + 1];
    for (std::size_t i = 0; i < places; ++i) first[i + 1] += first[i];
    pulls.resize(first.back());
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    for (std::size_t k = 0; k < windows.size(); ++k)
      for (const GroundLean::Pull& p : windows[k].pulls)
        pulls[next[p.place]++] = {static_cast<std::uint32_t>(k), p.x, p.y};
  }
  double pairs() const {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < first.size(); ++i)
      sum += 0.5 * std::pow(static_cast<double>(first[i + 1] - first[i]), 2);
    return sum;
  }
};

/// sum a_k var_B a_l^T over the places, both triangles.
MatrixXd shared(const std::vector<GroundLean>& windows, const GroundPicture& ground) {
  const auto variance = ground.variance().levels();
  const PullsByPlace by_place(windows, variance.size());
  const auto thin = static_cast<std::uint32_t>(std::max(1.0, std::ceil(by_place.pairs() / kMostPairs)));
  const auto n = static_cast<Index>(2 * windows.size());
  Eigen::MatrixXf c = Eigen::MatrixXf::Zero(n, n);
  for (std::size_t place = 0; place < variance.size(); ++place) {
    // Places are drawn without order, or the thinning would see a grid.
    if (thin > 1 && (static_cast<std::uint32_t>(place) * 2654435761U >> 12U) % thin != 0) continue;
    const float weight = variance[place] * static_cast<float>(thin);
    for (std::size_t i = by_place.first[place]; i < by_place.first[place + 1]; ++i) {
      const PullOfWindow& a = by_place.pulls[i];
      const float ax = weight * a.x, ay = weight * a.y;
      for (std::size_t j = by_place.first[place]; j <= i; ++j) {
        const PullOfWindow& b = by_place.pulls[j];
        float* at = &c(2 * b.window, 2 * a.window);
        at[0] += ax * b.x;
        at[1] += ax * b.y;
        at[n] += ay * b.x;
        at[n + 1] += ay * b.y;
      }
    }
  }
  const MatrixXd upper = c.cast<double>();
  MatrixXd all = upper + upper.transpose();
  for (Index k = 0; k < n; k += 2) all.block<2, 2>(k, k) *= 0.5;
  return all;
}

/// Mean of half the trace of the blocks that lie `lag` windows apart.
double mean_block(const MatrixXd& m, Index lag) {
  double sum = 0;
  const Index n = m.rows() / 2 - lag;
  for (Index k = 0; k < n; ++k) sum += 0.5 * m.block<2, 2>(2 * k, 2 * (k + lag)).trace();
  return sum / static_cast<double>(n);
}

/// Less the mean over all windows, from either side.
MatrixXd centred(const MatrixXd& m) {
  const Index n = m.rows();
  MatrixXd mean = MatrixXd::Zero(n, 2);
  for (Index k = 0; k < n; ++k) mean(k, k % 2) = 2.0 / static_cast<double>(n);
  const auto taken = [&](const MatrixXd& from) {
    const MatrixXd means = mean.transpose() * from;
    MatrixXd out = from;
    for (Index k = 0; k < n; ++k) out.row(k) -= means.row(k % 2);
    return out;
  };
  return taken(taken(m).transpose());
}

}  // namespace

SlowError slow_error(const std::vector<GroundLean>& windows, const GroundPicture& ground) {
  const auto count = static_cast<Index>(windows.size());
  if (count < 3) return {};
  const MatrixXd c = shared(windows, ground);
  MatrixXd information = -c, own = MatrixXd::Zero(2 * count, 2 * count);
  double told = 0;
  for (Index k = 0; k < count; ++k) {
    const Matrix2d& t = windows[static_cast<std::size_t>(k)].information;
    information.block<2, 2>(2 * k, 2 * k) = t;
    own.block<2, 2>(2 * k, 2 * k) = (t + c.block<2, 2>(2 * k, 2 * k)).inverse();
    told += 0.5 * t.inverse().trace() / static_cast<double>(count);
  }
  const Eigen::LLT<MatrixXd> factor(information);
  if (factor.info() != Eigen::Success) return {};
  const MatrixXd slow = centred(factor.solve(MatrixXd::Identity(2 * count, 2 * count)) - own);
  const double variance = mean_block(slow, 0);
  if (!(variance > 0)) return {};

  SlowError out;
  out.sd = std::sqrt(variance);
  out.widening = (mean_block(own, 0) + variance) / told;
  const double spacing =
      static_cast<double>(windows.back().frame - windows.front().frame) / static_cast<double>(count - 1);
  double integral = 0.5;
  for (Index lag = 1; lag < count / 2; ++lag) {
    const double share = mean_block(slow, lag) / variance;
    if (share <= 0) break;
    integral += share;
  }
  out.frames = spacing * integral;
  return out;
}

}  // namespace tribotrack::vision
