// fit.json, as `report` reads it, beside a meta file that is as it should be. Its runs were measured
// elsewhere: tracks have a target of their own.
#include "apps/report/data/collect.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  static const auto meta =
      folder.write("fit.json.meta.json",
                   R"({"program": "tribotrack", "version": "0.1.0", "schema": 1, "command": "run",
          "inputs": [{"path": "c/campaign.toml", "xxh3_128": "00"}],
          "configuration": {"platform": {"amplitude_mm": 0.28, "amplitude_mm_sd": 0.01},
            "part": {"diameter_mm": 6.0, "diameter_sd_mm": 0}, "fit": {"fixed": {"mu2": 0.1}},
            "runs": [{"alpha_rad": 1, "alpha_sd_rad": 0.01, "v_mm_s": 2, "v_sd_mm_s": 0.1, "cycles": 20},
                     {"alpha_rad": 2, "alpha_sd_rad": 0.01, "v_mm_s": 3, "v_sd_mm_s": 0.1, "cycles": 20},
                     {"alpha_rad": 3, "alpha_sd_rad": 0.01, "v_mm_s": 4, "v_sd_mm_s": 0.1, "cycles": 20}]}})");
  folder.write("fit.json", data, size);
  constexpr long few_steps = 2'000;  // of the model, which sanitizers make hundreds of times as slow
  fuzz::read_or_refuse(data, size, [&] { apps::collect(apps::RunFolder{folder.path()}, few_steps); });
  return 0;
}
