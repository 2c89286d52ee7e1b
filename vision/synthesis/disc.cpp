#include "vision/synthesis/disc.h"

#include <functional>
#include <numbers>

namespace tribotrack::vision {
namespace {

/// exp(-z) I_1(z), by its asymptotic series (Abramowitz and Stegun 9.7.1) where that is exact to 1e-15.
double scaled_bessel_i1(double z) {
  if (z < 40) return std::exp(-z) * std::cyl_bessel_i(1.0, z);
  double term = 1, sum = 1;
  for (int k = 1; k < 20; ++k) {
    term *= -(4.0 - (2 * k - 1) * (2 * k - 1)) / (k * 8 * z);
    sum += term;
    if (std::abs(term) < 1e-16) break;
  }
  return sum / std::sqrt(2 * std::numbers::pi * z);
}

/// Whole numbers in [low, high] and in the row; clamped first, because far-away circles do not fit an int.
PixelSpan pixels_between(double low, double high, int width) {
  PixelSpan span;
  span.first = static_cast<int>(std::ceil(std::clamp(low, 0.0, static_cast<double>(width))));
  span.last = static_cast<int>(std::floor(std::clamp(high, -1.0, width - 1.0)));
  return span;
}

/// Pixels of the row with any part within `radius` of the centre.
PixelSpan pixels_touched(Point centre, double radius, int row, int width) {
  const double dy = std::max(0.0, std::abs(row - centre.y) - 0.5);
  if (dy > radius) return {};
  const double half = std::sqrt(radius * radius - dy * dy) + 0.5;
  return pixels_between(centre.x - half, centre.x + half, width);
}

/// Pixels of the row that lie within `radius` of the centre with all their corners.
PixelSpan pixels_filled(Point centre, double radius, int row, int width) {
  const double dy = std::abs(row - centre.y) + 0.5;
  if (radius <= 0 || dy > radius) return {};
  const double half = std::sqrt(radius * radius - dy * dy) - 0.5;
  if (half < 0) return {};
  return pixels_between(centre.x - half, centre.x + half, width);
}

}  // namespace

BlurredCircle::BlurredCircle(double radius, double blur) : radius_(radius), blur_(blur) {
  if (!(radius > 0) || !(blur > 0)) return;
  constexpr int cells_per_blur = 24;
  first_ = std::max(0.0, radius - reach());
  const auto cells =
      static_cast<std::size_t>(std::ceil((radius + reach() - first_) / blur * cells_per_blur)) + 1;
  const double width = blur / cells_per_blur;
  cells_per_pixel_ = 1 / width;
  const double variance = blur * blur;
  const auto fall = [&](double rho) {
    const double apart = (radius - rho) / blur;
    return radius / variance * std::exp(-0.5 * apart * apart) * scaled_bessel_i1(rho * radius / variance);
  };
  const QuadratureRule rule = gauss_legendre(5);
  table_.resize(cells + 1);
  // From outside inwards; what lies beyond the table is its tail, less than reach() promises.
  double value = 0;
  for (std::size_t k = cells + 1; k-- > 0;) {
    const double rho = first_ + static_cast<double>(k) * width;
    if (k < cells)
      for (std::size_t i = 0; i < rule.nodes.size(); ++i)
        value += width * rule.weights[i] * fall(rho + (0.5 + rule.nodes[i]) * width);
    table_[k] = {value, -fall(rho) * width};
  }
}

RowBand row_band(const BlurredCircle& circle, std::span<const Point> centres, int row, int width) {
  RowBand band{{width, -1}, {0, width - 1}};
  for (const Point& centre : centres) {
    const PixelSpan touched = pixels_touched(centre, circle.radius() + circle.reach(), row, width);
    if (!touched.empty()) {
      band.touched.first = std::min(band.touched.first, touched.first);
      band.touched.last = std::max(band.touched.last, touched.last);
    }
    const PixelSpan filled = pixels_filled(centre, circle.radius() - circle.reach(), row, width);
    if (filled.empty()) {
      band.filled = {};
    } else {
      band.filled.first = std::max(band.filled.first, filled.first);
      band.filled.last = std::min(band.filled.last, filled.last);
    }
  }
  return band;
}

namespace {

constexpr double kReach = 4.5;       // scratch blurs beyond which nothing of a scratch is left
constexpr double kTolerance = 2e-5;  // of the contrast
constexpr double kSqrt2 = std::numbers::sqrt2;

/// Mean of exp(-x^2 / (2 width^2)) over the pixel around x.
double pixel_mean_of_lobe(double x, double width) {
  const double scale = 1 / (kSqrt2 * width);
  return width * std::sqrt(std::numbers::pi / 2) *
         (std::erf((x + 0.5) * scale) - std::erf((x - 0.5) * scale));
}

/// Distance of the farther end from the disc's centre.
double scratch_extent(const DiscLayer::Scratch& s) {
  const double x = s.half_length * s.cosine;
  const double y = s.half_length * s.sine;
  return std::max(std::hypot(s.u + x, s.v + y), std::hypot(s.u - x, s.v - y));
}

/// x in [low, high] such that |slope x + offset| <= limit also holds.
void narrow(double slope, double offset, double limit, double& low, double& high) {
  if (std::abs(slope) < 1e-12) {
    if (std::abs(offset) > limit) high = low - 1;
    return;
  }
  const double a = (-limit - offset) / slope;
  const double b = (limit - offset) / slope;
  low = std::max(low, std::min(a, b));
  high = std::min(high, std::max(a, b));
}

}  // namespace

DiscLayer::DiscLayer(const DiscAppearance& disc, std::uint64_t seed)
    : edge_{disc.radius_px, disc.edge_blur_px},
      level_(disc.level),
      highlight_(disc.highlight),
      highlight_offset_(-0.35 * disc.radius_px),
      highlight_width_(0.45 * disc.radius_px),
      scratch_blur_(std::max(disc.edge_blur_px, 0.02 * disc.radius_px)),
      scratch_rule_(gauss_legendre(gauss_points_for_edge(scratch_blur_, kTolerance))) {
  const CounterRandom random(seed, 0xd15cu);
  for (int j = 0; j < disc.scratches; ++j) {
    const double distance = 0.75 * disc.radius_px * std::sqrt(random.uniform(4 * j));
    const double bearing = 2 * std::numbers::pi * random.uniform(4 * j + 1);
    const double direction = std::numbers::pi * random.uniform(4 * j + 2);
    Scratch scratch;
    scratch.u = distance * std::cos(bearing);
    scratch.v = distance * std::sin(bearing);
    scratch.cosine = std::cos(direction);
    scratch.sine = std::sin(direction);
    scratch.half_length = disc.radius_px * (0.1 + 0.25 * random.uniform(4 * j + 3));
    scratch.contrast = (j % 2 == 0 ? 1 : -1) * disc.scratch_contrast;
    scratch.outermost = scratch_extent(scratch) + kReach * scratch_blur_;
    scratches_.push_back(scratch);
  }
  std::ranges::sort(scratches_, std::greater{}, &Scratch::outermost);
}

double DiscLayer::scratch_profile(const Scratch& scratch, double along, double across) const {
  const double reach = kReach * scratch_blur_;
  if (std::abs(across) > reach || std::abs(along) > scratch.half_length + reach) return 0;
  const double z = across / scratch_blur_;
  double profile = std::exp(-0.5 * z * z);
  if (std::abs(along) > scratch.half_length - reach) {
    const double scale = 1 / (kSqrt2 * scratch_blur_);
    profile *= 0.5 * (std::erf((along + scratch.half_length) * scale) -
                      std::erf((along - scratch.half_length) * scale));
  }
  return profile;
}

double DiscLayer::colour(double dx, double dy, double cos_theta, double sin_theta) const {
  const double u = cos_theta * dx - sin_theta * dy;
  const double v = -sin_theta * dx - cos_theta * dy;
  const double hx = dx - highlight_offset_;
  const double hy = dy - highlight_offset_;
  double colour = level_;
  if (highlight_ != 0) {
    colour += highlight_ * std::exp(-0.5 * (hx * hx + hy * hy) / (highlight_width_ * highlight_width_));
  }
  const double distance = std::sqrt(dx * dx + dy * dy);
  for (const Scratch& scratch : scratches_) {
    if (distance > scratch.outermost) break;  // nor do the others reach so far
    const double du = u - scratch.u;
    const double dv = v - scratch.v;
    colour += scratch.contrast * scratch_profile(scratch, scratch.cosine * du + scratch.sine * dv,
                                                 scratch.cosine * dv - scratch.sine * du);
  }
  return colour;
}

void DiscLayer::render_interior(std::span<const ExposureNode> nodes, std::span<const PixelSpan> filled,
                                Picture& picture) const {
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = filled[y].first; x <= filled[y].last; ++x) picture.at(x, y) = static_cast<float>(level_);
  }
  for (const ExposureNode& node : nodes) {
    if (highlight_ != 0) add_highlight(node, filled, picture);
    for (const Scratch& scratch : scratches_) add_scratch(scratch, node, filled, picture);
  }
}

void DiscLayer::add_highlight(const ExposureNode& node, std::span<const PixelSpan> filled,
                              Picture& picture) const {
  const double x_lobe = node.pose.disc.x + highlight_offset_;
  const double y_lobe = node.pose.disc.y + highlight_offset_;
  std::vector<float> columns(picture.width(), -1.0F);
  for (int y = 0; y < picture.height(); ++y) {
    if (filled[y].empty()) continue;
    const auto strength =
        static_cast<float>(node.weight * highlight_ * pixel_mean_of_lobe(y - y_lobe, highlight_width_));
    for (int x = filled[y].first; x <= filled[y].last; ++x) {
      if (columns[x] < 0) columns[x] = static_cast<float>(pixel_mean_of_lobe(x - x_lobe, highlight_width_));
      picture.at(x, y) += strength * columns[x];
    }
  }
}

void DiscLayer::add_scratch(const Scratch& scratch, const ExposureNode& node,
                            std::span<const PixelSpan> filled, Picture& picture) const {
  // Middle and direction in pixels, y down.
  const double c = std::cos(node.pose.theta);
  const double s = std::sin(node.pose.theta);
  const double x0 = node.pose.disc.x + c * scratch.u - s * scratch.v;
  const double y0 = node.pose.disc.y - s * scratch.u - c * scratch.v;
  const double ex = c * scratch.cosine - s * scratch.sine;
  const double ey = -(s * scratch.cosine + c * scratch.sine);
  const double corner = 0.75;  // from a pixel's centre to its corner
  const double across_limit = kReach * scratch_blur_ + corner;
  const double along_limit = across_limit + scratch.half_length;
  const double half_height = along_limit * std::abs(ey) + across_limit * std::abs(ex);
  const double last_row = picture.height() - 1.0;
  const int y_first = static_cast<int>(std::ceil(std::clamp(y0 - half_height, 0.0, last_row + 1)));
  const int y_last = static_cast<int>(std::floor(std::clamp(y0 + half_height, -1.0, last_row)));
  for (int y = y_first; y <= y_last; ++y) {
    if (filled[y].empty()) continue;
    double low = filled[y].first - x0;
    double high = filled[y].last - x0;
    narrow(ex, ey * (y - y0), along_limit, low, high);
    narrow(ey, -ex * (y - y0), across_limit, low, high);
    if (low > high) continue;
    for (int x = static_cast<int>(std::ceil(low + x0)); x <= static_cast<int>(std::floor(high + x0)); ++x) {
      double mean = 0;
      for (std::size_t j = 0; j < scratch_rule_.nodes.size(); ++j) {
        const double dy = y + scratch_rule_.nodes[j] - y0;
        double row_mean = 0;
        for (std::size_t i = 0; i < scratch_rule_.nodes.size(); ++i) {
          const double dx = x + scratch_rule_.nodes[i] - x0;
          // Seen with y up the direction's left is positive; the profile is symmetric and does not care.
          row_mean +=
              scratch_rule_.weights[i] * scratch_profile(scratch, ex * dx + ey * dy, ey * dx - ex * dy);
        }
        mean += scratch_rule_.weights[j] * row_mean;
      }
      picture.at(x, y) += static_cast<float>(node.weight * scratch.contrast * mean);
    }
  }
}

}  // namespace tribotrack::vision
