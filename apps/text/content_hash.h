// The hash that tells one recording from another.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tribotrack::apps {

/// What is read of a large file. Reading all of a recording of gigabytes only to name it takes longer than
/// tracking a disc in it; two different recordings differ in the noise of every picture, so a part of each
/// tells them apart.
struct Sampling {
  std::uint64_t whole_up_to = 32 << 20;  ///< bytes: smaller files are hashed whole
  std::uint64_t ends = 1 << 20;          ///< bytes of the beginning and of the end, hashed always
  std::uint64_t blocks = 256;            ///< spread evenly over what lies between
  std::uint64_t block = 64 << 10;        ///< bytes of each
};

struct ContentHash {
  std::string xxh3_128;             ///< in hex
  std::uint64_t sampled_bytes = 0;  ///< what was read of large files and all smaller ones; 0: every byte
};

/// XXH3-128 of the files' bytes one after the other. Of a file larger than `whole_up_to`, its size and the
/// sample stand for it; where a format keeps what it tells of its pictures (times above all) before them,
/// that is hashed whole. Throws InvalidInput where a file cannot be read.
ContentHash hash_of_files(const std::vector<std::filesystem::path>& files, const Sampling& sampling);

std::string hash_of_text(std::string_view text);

}  // namespace tribotrack::apps
