#include "apps/files/camera_section.h"

#include <fmt/format.h>

#include <stdexcept>

#include "apps/files/marker_word.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

std::optional<vision::Circle> read_circle(StrictTable& table, const char* key) {
  const auto values = table.numbers(key, 3);
  if (!values) return std::nullopt;
  if (!((*values)[2] > 0))
    table.fail(key, fmt::format("must have a radius greater than 0, not {}", (*values)[2]));
  return vision::Circle{(*values)[0], (*values)[1], (*values)[2]};
}

namespace {

vision::Rect rect_of(const StrictTable& table, const char* key, const std::vector<std::int64_t>& values) {
  for (const std::int64_t value : values)
    if (value < 0 || value > 65535) table.fail(key, fmt::format("must lie in the picture, not at {}", value));
  const vision::Rect rect{static_cast<int>(values[0]), static_cast<int>(values[1]),
                          static_cast<int>(values[2]), static_cast<int>(values[3])};
  if (rect.width < 8 || rect.height < 8)
    table.fail(key, fmt::format("is [x, y, width, height], at least 8 x 8 pixels, not {} x {}", rect.width,
                                rect.height));
  return rect;
}

}  // namespace

std::optional<vision::Rect> read_template(StrictTable& table) {
  const auto values = table.integers("template_px", 4);
  if (!values) return std::nullopt;
  if (table.has("disc_px")) table.fail("template_px", "and `disc_px` are two parts; give one of them");
  return rect_of(table, "template_px", *values);
}

PartPlace read_place(StrictTable& table, const char* key) {
  if (table.count(key) == 4) return {{}, rect_of(table, key, *table.integers(key, 4))};
  return {read_circle(table, key), {}};
}

namespace {

/// A tag of known size sets the scale.
void read_tag_size(StrictTable& table, CameraSection& camera) {
  if (camera.marker_px && camera.marker.kind == vision::MarkerChoice::Kind::tag)
    table.fail("marker_px", "and a tag are two marks of the platform; give one of them");
  camera.tag_mm = table.positive("tag_mm");
  camera.tag_mm_sd = read_sd(table, "tag_mm").value_or(0);
  if (!camera.tag_mm) return;
  if (camera.marker.kind != vision::MarkerChoice::Kind::tag)
    table.fail("tag_mm", "is the size of a tag; say which: marker = \"tag:apriltag_36h11\"");
  if (camera.mm_per_px || camera.calibration)
    table.fail("tag_mm", fmt::format("gives the scale, and so does {}: leave one out",
                                     camera.mm_per_px ? "mm_per_px" : "calibration"));
}

}  // namespace

CameraSection read_camera(StrictTable& table, const fs::path& folder, WithSd with_sd) {
  CameraSection camera;
  camera.frame_rate_hz = table.positive("frame_rate_hz");
  camera.frame_rate_reason = table.text("frame_rate_reason").value_or("");
  if (!camera.frame_rate_reason.empty() && !camera.frame_rate_hz)
    table.fail("frame_rate_reason", "needs frame_rate_hz");
  camera.mm_per_px = table.positive("mm_per_px");
  camera.mm_per_px_sd = table.not_negative("mm_per_px_sd").value_or(0);
  if (camera.mm_per_px_sd > 0 && !camera.mm_per_px) table.fail("mm_per_px_sd", "needs mm_per_px");
  if (const auto file = table.text("calibration")) {
    if (camera.mm_per_px) table.fail("calibration", "gives the scale, and so does mm_per_px: leave one out");
    camera.calibration = folder / *file;
    if (!fs::exists(*camera.calibration))
      table.fail("calibration", fmt::format("names {}, which is not there; check its name, or make it with "
                                            "`tribotrack calibrate`",
                                            camera.calibration->string()));
  }
  camera.xi_axis_rad = table.angle("xi_axis_rad").value_or(0);
  if (table.has("rehearse"))
    table.fail("rehearse",
               "has left: standard deviations count what the coder may have done; leave the key out, and for "
               "smaller ones film uncompressed or FFV1");
  camera.row_time_s = table.number("row_time_s").value_or(0);
  camera.working_distance_mm = table.positive("working_distance_mm");
  if (with_sd == WithSd::yes) {
    camera.frame_rate_sd_hz = read_sd(table, "frame_rate_hz");
    camera.xi_axis_sd_rad = read_sd(table, "xi_axis_rad");
    camera.working_distance_sd_mm = read_sd(table, "working_distance_mm");
  }
  camera.disc_px = read_circle(table, "disc_px");
  camera.template_px = read_template(table);
  camera.marker_px = read_circle(table, "marker_px");
  camera.gate_px = read_circle(table, "gate_px");
  if (const auto word = table.text("marker")) {
    try {
      const auto marker = marker_named(*word);
      if (!marker) table.fail("marker", fmt::format("must be {}, not \"{}\"", kMarkerWords, *word));
      camera.marker = *marker;
    } catch (const std::invalid_argument& error) {
      table.fail("marker", fmt::format("names no tag: {}", error.what()));
    }
  }
  read_tag_size(table, camera);
  table.finish();
  return camera;
}

PartSection read_part(StrictTable& table, WithSd with_sd) {
  PartSection part;
  part.name = table.text("name").value_or("");
  part.disc_px = read_circle(table, "disc_px");
  part.template_px = read_template(table);
  part.diameter_mm = table.positive("diameter_mm");
  const auto earlier_name = table.not_negative("diameter_sd_mm");
  const auto diameter_sd = read_sd(table, "diameter_mm");
  if (earlier_name && diameter_sd)
    table.fail("diameter_sd_mm", "and `diameter_mm_sd` mean the same; give one of them");
  if (earlier_name.value_or(0) > 0 && !part.diameter_mm)
    table.fail("diameter_sd_mm",
               "is the sd of `diameter_mm`, which is not given here: give both, or neither");
  part.diameter_sd_mm = diameter_sd.value_or(earlier_name.value_or(0));
  part.height_mm = table.positive("height_mm");
  if (with_sd == WithSd::yes) part.height_sd_mm = read_sd(table, "height_mm");
  table.finish();
  return part;
}

}  // namespace tribotrack::apps
