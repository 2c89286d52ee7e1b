// A sweep in parts, each solved by a job of its own, and the whole from its parts.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/text/json.h"

namespace tribotrack::apps {

/// Part `number` of `of` parts of a row of scenarios: neighbours, as evenly many in each as can be.
struct SweepPart {
  std::size_t number = 1, of = 1;
  std::size_t begin(std::size_t count) const { return place(number - 1, count); }
  std::size_t end(std::size_t count) const { return place(number, count); }

 private:
  std::size_t place(std::size_t parts, std::size_t count) const {
    // Of at most 1e8 scenarios and parts: the product fits.
    return parts * count / of;
  }
};

/// "3/8". Throws UsageError.
SweepPart sweep_part(const std::string& text);

/// What a part's meta file says of it.
Json json_of(const SweepPart& part, std::size_t rows);

/// The whole from its parts, byte for byte what one `sweep` writes.
struct JoinedSweep {
  std::string text;  ///< the table; of parts printed with --json, that object
  Json meta;         ///< what stands beside the table; null for JSON
};

/// Tables may come in any order, their meta files beside them: all parts of one sweep, each once. Objects of
/// `--json` tell no part from another: they are joined in the order given. Throws InvalidInput naming the
/// file.
JoinedSweep joined_sweep(const std::vector<std::filesystem::path>& parts);

}  // namespace tribotrack::apps
