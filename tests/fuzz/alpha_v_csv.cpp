// A table of alpha and v, and the runs of a campaign that names it.
#include "apps/files/campaign/campaign.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  static const auto campaign = folder.write("c.toml", "[data]\ntable = \"alpha_v.csv\"\n");
  folder.write("alpha_v.csv", data, size);
  fuzz::read_or_refuse(data, size, [&] { apps::read_campaign(campaign); });
  return 0;
}
