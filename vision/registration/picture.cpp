// TemplateRegistration, picture: grey levels and weights under the template at a pose.
#include <algorithm>
#include <cmath>

#include "vision/registration/registration.h"

namespace tribotrack::vision {

/// Weight of the template pixel that lies under pixel (x, y) of the window once the template is turned.
float TemplateRegistration::turned_weight(int x, int y, double c, double s) const {
  const Rect& w = pattern_.window;
  const double rx = x + w.x - pattern_.centre.x;
  const double ry = y + w.y - pattern_.centre.y;
  const int u = static_cast<int>(std::lround(pattern_.centre.x + c * rx - s * ry)) - w.x;
  const int v = static_cast<int>(std::lround(pattern_.centre.y + s * rx + c * ry)) - w.y;
  const bool inside = u >= 0 && v >= 0 && u < w.width && v < w.height;
  return inside ? std::min(pattern_.weights.at(u, v), pattern_.radius > 0 ? 1.0F : pattern_.weights.at(x, y))
                : 0.0F;
}

/// Grey levels under the tiles moved by whole pixels; weight 0 outside the picture. False where less than
/// half of the mask is covered.
bool TemplateRegistration::take_picture(const Picture& picture, int x, int y, int whole_x, int whole_y,
                                        double theta) {
  const Rect& w = pattern_.window;
  const bool turned = gaps_ && options_.rotation && theta != 0;
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  if (!whole_mask_) base_weight_ = mask_;
  bool all_inside = true;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const int left = places_[t].x + w.x + whole_x - x;
    const int top = places_[t].y + w.y + whole_y - y;
    float* level = arrays_.level.data() + t * kTilePixels;
    float* weight = base_weight_.data() + t * kTilePixels;
    const bool inside =
        left >= 0 && top >= 0 && left + kTile <= picture.width() && top + kTile <= picture.height();
    all_inside &= inside;
    for (int j = 0; j < kTile; ++j, level += kTile, weight += kTile) {
      if (inside) {
        const float* from = picture.row(top + j).data() + left;
        for (int i = 0; i < kTile; ++i) level[i] = from[i] - pivot_;
      } else {
        for (int i = 0; i < kTile; ++i) {
          const bool seen =
              left + i >= 0 && left + i < picture.width() && top + j >= 0 && top + j < picture.height();
          level[i] = seen ? picture.at(left + i, top + j) - pivot_ : 0.0F;
          if (!seen) weight[i] = 0;
        }
      }
      if (turned)
        for (int i = 0; i < kTile; ++i)
          if (weight[i] > 0) weight[i] = turned_weight(places_[t].x + i, places_[t].y + j, c, s);
    }
  }
  // What the frame before changed: mostly nothing.
  const bool whole = all_inside && !turned;
  if (trimmed_ || !whole || !whole_mask_) arrays_.weight = base_weight_;
  trimmed_ = false;
  whole_mask_ = whole;
  if (whole) return true;
  double covered = 0;
  for (const float weight : base_weight_) covered += weight;
  return covered > 0.5 * pixels_;
}

}  // namespace tribotrack::vision
