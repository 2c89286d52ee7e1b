// A track of another program, with all that its file may leave open given.
#include "apps/files/tracks/any_track.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("x.csv", data, size);
  apps::TrackReading reading;
  reading.unit = "mm";
  reading.y = apps::TrackReading::YAxis::up;
  reading.mm_per_px = 0.1;
  fuzz::read_or_refuse(data, size, [&] { apps::read_any_track(file, reading); });
  return 0;
}
