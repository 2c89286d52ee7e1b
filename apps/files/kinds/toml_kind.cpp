#include "apps/files/kinds/toml_kind.h"

#include <fmt/format.h>

#include <optional>

#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

/// nullopt where its tables do not tell.
std::optional<TomlKind> kind_of(const StrictTable& top) {
  if (top.has("shot") || top.has("video") || top.has("disc")) return TomlKind::scene;
  if (top.is_list("run") || top.has("fit") || top.has("data")) return TomlKind::campaign;
  if (top.is_table("run") || top.has("friction") || top.has("sweep")) return TomlKind::scenario;
  return std::nullopt;
}

const char* name_of(TomlKind kind) {
  return kind == TomlKind::campaign ? "campaign" : kind == TomlKind::scenario ? "scenario" : "scene";
}

std::string command_for(TomlKind kind, const std::string& file) {
  switch (kind) {
    case TomlKind::campaign:
      return fmt::format("`tribotrack run {} -o DIR` takes it", file);
    case TomlKind::scenario:
      return fmt::format("`tribotrack simulate {}` takes it", file);
    case TomlKind::scene:
      break;
  }
  return fmt::format("`tribotrack synth {} -o VIDEO` takes it", file);
}

}  // namespace

void require_kind(const StrictTable& top, TomlKind wanted, const std::string& file) {
  const auto kind = kind_of(top);
  if (kind && *kind != wanted)
    throw InvalidInput(fmt::format("{}: is a {}, not a {}; {}", file, name_of(*kind), name_of(wanted),
                                   command_for(*kind, file)));
}

}  // namespace tribotrack::apps
