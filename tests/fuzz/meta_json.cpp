// A meta file: a track's, and that of a fit, as `report` reads it.
#include "apps/files/track_file.h"
#include "apps/report/data/collect.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("t.csv.meta.json", data, size);
  fuzz::read_or_refuse(data, size, [&] {
    const apps::Json meta = apps::read_json(file);
    fuzz::read_or_refuse(data, size, [&] { apps::track_described_by(meta, file); });
    apps::ReportData report;
    apps::add_provenance(meta, file, report);
  });
  return 0;
}
