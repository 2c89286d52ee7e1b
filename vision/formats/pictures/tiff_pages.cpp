#include "vision/formats/pictures/tiff_pages.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <unordered_set>

#include "vision/io/in_quotes.h"
#include "vision/io/mapped_file.h"
#include "vision/io/picture_size.h"
#include "vision/picture.h"

namespace tribotrack::vision {
namespace {

class TiffFile {
 public:
  explicit TiffFile(const std::filesystem::path& path) : file_(path) {
    const auto head = file_.bytes(0, 8, "the TIFF header");
    big_endian_ = head[0] == 'M';
    const bool marked = head[0] == head[1] && (head[0] == 'I' || head[0] == 'M');
    const std::uint64_t version = number(2, 2, "the TIFF header");
    if (!marked || (version != 42 && version != 43))
      throw InputError(in_quotes(path) + " is not a TIFF; check the file and its extension");
    large_ = version == 43;
  }

  struct Size {
    std::uint64_t width = 0, height = 0;
  };

  /// Calls `visit(place, entries)` with each page's directory; how many there are.
  template <class Visit>
  std::int64_t for_pages(const Visit& visit) const {
    std::unordered_set<std::uint64_t> seen;
    std::uint64_t walked = 0;
    const std::uint64_t word = large_ ? 8 : 4, count_bytes = large_ ? 8 : 2;
    std::uint64_t page = number(large_ ? 8 : 4, word, "the place of the first page");
    while (page != 0) {
      const std::string what = "the directory of page " + std::to_string(seen.size());
      if (!seen.insert(page).second)
        throw InputError(in_quotes(file_.path()) + " is damaged: its page list is circular; export it again");
      const std::uint64_t entries = number(page, count_bytes, what);
      if (entries > 65535)
        throw InputError(in_quotes(file_.path()) + " is damaged: " + what + " is invalid; export it again");
      walked += entries * entry_bytes();
      if (walked > file_.size())
        throw InputError(in_quotes(file_.path()) + " is damaged: " + what +
                         " shares bytes with others; export it again");
      const std::uint64_t next = number(page + count_bytes + entries * entry_bytes(), word, what);
      visit(page + count_bytes, entries);
      page = next;
    }
    return static_cast<std::int64_t>(seen.size());
  }

  /// The page's picture, and the tiles it is made of; 0 where it states none.
  std::array<Size, 2> sizes(std::uint64_t directory, std::uint64_t entries) const {
    constexpr std::uint64_t kWidth = 256, kHeight = 257, kTileWidth = 322, kTileHeight = 323;
    std::array<Size, 2> found;
    for (std::uint64_t k = 0; k < entries; ++k) {
      const std::uint64_t entry = directory + k * entry_bytes();
      switch (number(entry, 2, "a directory")) {
        case kWidth:
          found[0].width = value(entry);
          break;
        case kHeight:
          found[0].height = value(entry);
          break;
        case kTileWidth:
          found[1].width = value(entry);
          break;
        case kTileHeight:
          found[1].height = value(entry);
          break;
        default:
          break;
      }
    }
    return found;
  }

 private:
  std::uint64_t entry_bytes() const { return large_ ? 20 : 12; }
  /// Of an entry that holds one whole number: of 2, 4 or 8 bytes.
  std::uint64_t value(std::uint64_t entry) const {
    constexpr std::uint64_t kShort = 3, kLong8 = 16;
    const std::uint64_t type = number(entry + 2, 2, "a directory");
    const std::uint64_t bytes = type == kShort ? 2 : type == kLong8 && large_ ? 8 : 4;
    return number(entry + (large_ ? 12 : 8), bytes, "a directory");
  }
  std::uint64_t number(std::uint64_t offset, std::uint64_t count, const std::string& what) const {
    const auto bytes = file_.bytes(offset, count, what);
    std::uint64_t value = 0;
    for (std::uint64_t i = 0; i < count; ++i) value = value << 8 | bytes[big_endian_ ? i : count - 1 - i];
    return value;
  }

  MappedFile file_;
  bool big_endian_ = false, large_ = false;
};

}  // namespace

std::int64_t count_tiff_pages(const std::filesystem::path& path) {
  return TiffFile(path).for_pages([](std::uint64_t, std::uint64_t) {});
}

void require_sensible_pages(const std::filesystem::path& path) {
  const TiffFile file(path);
  file.for_pages([&](std::uint64_t directory, std::uint64_t entries) {
    for (const TiffFile::Size& size : file.sizes(directory, entries)) {
      constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
      if (size.width != 0 && size.height != 0)
        require_sensible_size(path, static_cast<std::int64_t>(std::min(size.width, most)),
                              static_cast<std::int64_t>(std::min(size.height, most)),
                              std::filesystem::file_size(path));
    }
  });
}

}  // namespace tribotrack::vision
