// A scenario, for `simulate` and `sweep`.
#include "apps/files/scenario_file.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("scenario.toml", data, size);
  fuzz::read_or_refuse(data, size, [&] {
    const model::Scenario scenario = apps::read_scenario_file(file).scenario;
    scenario.validate();
    apps::text_of(apps::json_of(scenario));
  });
  return 0;
}
