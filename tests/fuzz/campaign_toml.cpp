// A campaign.
#include "apps/files/campaign/campaign.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("campaign.toml", data, size);
  fuzz::read_or_refuse(data, size,
                       [&] { apps::text_of(apps::read_campaign(file).effective_configuration()); });
  return 0;
}
