// A .cine: its head, its times, and the pictures that its table points to.
#include <algorithm>

#include "fuzz/target.h"
#include "vision/frame_source.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("a.cine", data, size);
  std::unique_ptr<vision::FrameSource> source;
  fuzz::read_or_refuse(data, size, [&] { source = vision::open_source(file); });
  vision::bytes_before_pictures(file);
  if (!source) return 0;
  const auto& info = source->info();
  const std::int64_t last = info.frame_count - 1;
  const vision::Rect corner{info.width - 1, info.height - 1, 1, 1};
  vision::Picture picture;
  for (const std::int64_t index : {std::int64_t{0}, std::min<std::int64_t>(1, last), last / 2, last})
    fuzz::read_or_refuse(data, size, [&] {
      source->read(index, corner, picture);
      source->read(index, source->bounds(), picture);
      if (info.time_base.known()) source->time_s(index);
      source->exposure_s(index);
    });
  return 0;
}
