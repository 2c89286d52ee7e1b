// The table of a track, beside a meta file that is as it should be.
#include "apps/files/track_file.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  static const auto meta =
      folder.write("t.csv.meta.json",
                   R"({"schema": 1, "scale": {"mm_per_px": 0.1, "mm_per_px_sd": 0.001, "source": "given"},
          "recording": {"format": "cine", "first_image": -5, "exposure_s": 0.0005, "width": 320, "height": 320},
          "time_base": {"rate_hz": 250, "source": "cine header"},
          "slow_errors": [{"from": "light", "sd_px": 0.01, "time_s": 0.1}],
          "summary": {"disc_px": [111, 92, 30], "frames": 3}})");
  const auto file = folder.write("t.csv", data, size);
  fuzz::read_or_refuse(data, size, [&] { apps::read_track_file(file); });
  return 0;
}
