#include "vision/layers/model/ring_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <utility>
#include <vector>

namespace tribotrack::vision {
namespace {

using Waves = Eigen::Matrix<double, 5, 1>;

struct Ring {
  Eigen::Matrix<double, 5, 5> normal;
  Waves right = Waves::Zero();
  double observations = 0;
};

/// Calls act(place, ring below, share of the ring above, waves) for every place of the grid.
template <class Act>
void for_each_place(int size, const Act& act) {
  const int half = size / 2;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const double rho = std::hypot(i - half, j - half), phi = std::atan2(j - half, i - half);
      const auto ring = static_cast<std::size_t>(rho);
      Waves waves;
      waves << 1, std::cos(phi), std::sin(phi), std::cos(2 * phi), std::sin(2 * phi);
      act(static_cast<std::size_t>(j) * static_cast<std::size_t>(size) + static_cast<std::size_t>(i), ring,
          rho - static_cast<double>(ring), waves);
    }
}

}  // namespace

Picture ring_fit(const Picture& values, const Picture& weights, double sd, const RingLimit* limit) {
  const int size = values.width();
  std::vector<Ring> rings(static_cast<std::size_t>(size) + 2);
  for (Ring& ring : rings) ring.normal.setZero();
  for_each_place(size, [&](std::size_t at, std::size_t below, double above, const Waves& waves) {
    const auto weight = static_cast<double>(weights.levels()[at]);
    const auto value = static_cast<double>(values.levels()[at]);
    for (const auto& [ring, share] : {std::pair{below, 1 - above}, std::pair{below + 1, above}}) {
      rings[ring].normal += share * weight * waves * waves.transpose();
      rings[ring].right += share * weight * value * waves;
      if (limit) rings[ring].observations += share * static_cast<double>(limit->observations.levels()[at]);
    }
  });
  std::vector<Waves> fitted;
  const Eigen::Matrix<double, 5, 5> prior = Eigen::Matrix<double, 5, 5>::Identity() / (sd * sd);
  for (const Ring& ring : rings) {
    const double share = limit && ring.observations > limit->most ? limit->most / ring.observations : 1;
    fitted.push_back((prior + share * ring.normal).ldlt().solve(share * ring.right));
  }
  Picture out(size, size);
  for_each_place(size, [&](std::size_t at, std::size_t below, double above, const Waves& waves) {
    out.levels()[at] =
        static_cast<float>(((1 - above) * fitted[below] + above * fitted[below + 1]).dot(waves));
  });
  return out;
}

}  // namespace tribotrack::vision
