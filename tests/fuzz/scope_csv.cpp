// The table of an oscilloscope.
#include "apps/files/traces/scope_file.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("scope.csv", data, size);
  fuzz::read_or_refuse(data, size, [&] { apps::read_scope_file(file); });
  return 0;
}
