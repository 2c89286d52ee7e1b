// Reads every file of the corpus once, each folder by the target of its name: an ordinary test.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

#include "fuzz/target.h"

#define TARGET(name) extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size);
TARGETS
#undef TARGET

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
#define TARGET(name) {#name, &fuzz_##name},
  const std::map<std::string, int (*)(const std::uint8_t*, std::size_t)> targets = {TARGETS};
#undef TARGET
  if (argc != 2) return 2;
  for (const auto& [name, read] : targets) {
    int files = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(argv[1]) / name)) {
      std::fprintf(stderr, "%s\n", entry.path().c_str());
      std::ifstream file(entry.path(), std::ios::binary);
      const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
      read(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
      ++files;
    }
    if (files == 0) return 1;
  }
  return 0;
}
