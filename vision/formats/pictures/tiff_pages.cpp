#include "vision/formats/pictures/tiff_pages.h"

#include <string>
#include <unordered_set>

#include "vision/io/in_quotes.h"
#include "vision/io/mapped_file.h"
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

  std::int64_t count_pages() const {
    std::unordered_set<std::uint64_t> seen;
    const std::uint64_t word = large_ ? 8 : 4, count_bytes = large_ ? 8 : 2, entry_bytes = large_ ? 20 : 12;
    std::uint64_t page = number(large_ ? 8 : 4, word, "the place of the first page");
    while (page != 0) {
      const std::string what = "the directory of page " + std::to_string(seen.size());
      if (!seen.insert(page).second)
        throw InputError(in_quotes(file_.path()) + " is damaged: its page list is circular; export it again");
      const std::uint64_t entries = number(page, count_bytes, what);
      if (entries > 65535)
        throw InputError(in_quotes(file_.path()) + " is damaged: " + what + " is invalid; export it again");
      page = number(page + count_bytes + entries * entry_bytes, word, what);
    }
    return static_cast<std::int64_t>(seen.size());
  }

 private:
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
  return TiffFile(path).count_pages();
}

}  // namespace tribotrack::vision
