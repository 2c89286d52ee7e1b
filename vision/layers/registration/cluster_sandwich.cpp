// What a frame holds that neither layer has (glare, the shadow of a hand): how far it may have drawn the
// disc.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "vision/layers/registration/registration.h"

namespace tribotrack::vision {
namespace {

constexpr int kPatch = 3 * kTile;  ///< px over which such residuals are taken to be alike

}  // namespace

/// Sandwich estimate N^-1 (sum s s') N^-1 with patches of the picture as clusters, s the sum of w r J over
/// one [Liang and Zeger, Biometrika 73 (1986) 13].
Eigen::Matrix2d LayeredRegistration::scattered(const Matrix& inverse) const {
  std::map<std::pair<int, int>, Vector> patches;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const TilePlace& place = places_[t];
    const auto at = [](int v) { return static_cast<int>(std::floor((v + 0.5 * kTile) / kPatch)); };
    Vector& score = patches.try_emplace({at(place.x), at(place.y)}, Vector::Zero(columns())).first->second;
    for (std::size_t i = t * kTilePixels; i < (t + 1) * kTilePixels; ++i) {
      if (!(counts_[i] > 0)) continue;
      const double pull = static_cast<double>(arrays_.weight[i] * residual(i, light_));
      const double disc = static_cast<double>(arrays_.disc.value[i]);
      score(kStepX) += pull * static_cast<double>(arrays_.step_x[i]);
      score(kStepY) += pull * static_cast<double>(arrays_.step_y[i]);
      score(kGain) += pull * disc;
      score(kSlopeX) += pull * disc * static_cast<double>(arrays_.u[i]);
      score(kSlopeY) += pull * disc * static_cast<double>(arrays_.v[i]);
      score(kGround) +=
          pull * static_cast<double>(arrays_.share.value[i] * arrays_.ground.value[i] + arrays_.blended[i]);
      if (disc_.turning()) score(kTurn) += pull * light_.gain * static_cast<double>(arrays_.turn.value[i]);
    }
  }
  Matrix meat = Matrix::Zero(columns(), columns());
  for (const auto& [where, score] : patches) meat.noalias() += score * score.transpose();
  const Matrix spread = inverse * meat * inverse;
  return spread.topLeftCorner<2, 2>();
}

}  // namespace tribotrack::vision
