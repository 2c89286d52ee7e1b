// What `calibrate` found out about a camera.
#include "apps/files/camera.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("calibration.json", data, size);
  fuzz::read_or_refuse(data, size, [&] { apps::read_calibration(file); });
  return 0;
}
