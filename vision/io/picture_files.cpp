#include "vision/io/picture_files.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <unordered_set>

#include "vision/io/files.h"
#include "vision/picture.h"
#include "vision/temporary_file.h"

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
      refuse(path, "is not a TIFF; check the file and its extension");
    large_ = version == 43;
  }

  struct Size {
    std::uint64_t width = 0, height = 0;
  };

  /// Calls `visit(place, entries)` with each page's directory; how many there are.
  std::int64_t for_pages(const auto& visit) const {
    std::unordered_set<std::uint64_t> seen;
    std::uint64_t walked = 0;
    const std::uint64_t word = large_ ? 8 : 4, count_bytes = large_ ? 8 : 2;
    std::uint64_t page = number(large_ ? 8 : 4, word, "the place of the first page");
    while (page != 0) {
      const std::string what = "the directory of page " + std::to_string(seen.size());
      if (!seen.insert(page).second)
        refuse(file_.path(), "is damaged: its page list is circular; export it again");
      const std::uint64_t entries = number(page, count_bytes, what);
      if (entries > 65535) refuse(file_.path(), "is damaged: {} is invalid; export it again", what);
      walked += entries * entry_bytes();
      if (walked > file_.size())
        refuse(file_.path(), "is damaged: {} shares bytes with others; export it again", what);
      const std::uint64_t next = number(page + count_bytes + entries * entry_bytes(), word, what);
      visit(page + count_bytes, entries);
      page = next;
    }
    return static_cast<std::int64_t>(seen.size());
  }

  /// The page's picture and the tiles it is made of, 0 where it states none; bits of a sample, samples.
  struct Page {
    Size picture, tile;
    std::uint64_t bits = 1, samples = 1;
  };
  Page page(std::uint64_t directory, std::uint64_t entries) const {
    constexpr std::uint64_t kBits = 258;
    Page found;
    const std::pair<std::uint64_t, std::uint64_t*> wanted[] = {{256, &found.picture.width},
                                                               {257, &found.picture.height},
                                                               {277, &found.samples},
                                                               {322, &found.tile.width},
                                                               {323, &found.tile.height}};
    for (std::uint64_t k = 0; k < entries; ++k) {
      const std::uint64_t entry = directory + k * entry_bytes(), tag = number(entry, 2, "a directory");
      for (const auto& [known, field] : wanted)
        if (tag == known) *field = value(entry);
      if (tag != kBits) continue;
      // One number for each sample; more than fit here stand elsewhere.
      const std::uint64_t room = large_ ? 8 : 4, count = number(entry + 4, room, "a directory"),
                          at = entry + 4 + room;
      found.bits = number(count > room / 2 ? number(at, room, "a directory") : at, 2, "the bits of a sample");
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

/// Throws InputError where a page, or the tiles it is made of, are larger than vision/io/files.h allows.
void require_sensible_pages(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{256} << 20, kDensest = 2048,
                          kMost = 64;  // as require_sensible_size(); bits, samples
  const TiffFile file(path);
  std::uint64_t all = 0;
  file.for_pages([&](std::uint64_t directory, std::uint64_t entries) {
    const TiffFile::Page page = file.page(directory, entries);
    for (const TiffFile::Size& size : {page.picture, page.tile}) {
      constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
      if (size.width != 0 && size.height != 0)
        require_sensible_size(path, static_cast<std::int64_t>(std::min(size.width, most)),
                              static_cast<std::int64_t>(std::min(size.height, most)),
                              std::filesystem::file_size(path));
    }
    const std::uint64_t depth = std::min(page.bits, kMost) * std::min(page.samples, kMost);
    const std::uint64_t bytes = page.picture.width * page.picture.height * depth / 8;
    all += bytes;
    if (bytes > kMostBytes || all / kDensest > std::filesystem::file_size(path))
      refuse(path,
             "is damaged or too large: it claims pictures of {} MB, where a page of {} and in all {} times "
             "the file are read; export it again, or crop it",
             std::max(bytes, all) >> 20, kMostBytes >> 20, kDensest);
  });
}

}  // namespace

std::int64_t count_tiff_pages(const std::filesystem::path& path) {
  return TiffFile(path).for_pages([](std::uint64_t, std::uint64_t) {});
}

void require_decodable_picture(const std::filesystem::path& path) {
  const MappedFile file(path);
  const auto bytes = file.bytes(0, file.size(), "the picture");
  const std::string_view begin(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (begin.starts_with("II") || begin.starts_with("MM")) return require_sensible_pages(path);
  const bool pnm = begin.size() > 2 && begin[0] == 'P' && begin[1] >= '1' && begin[1] <= '6';
  for (const std::string_view mark : {"\x89PNG\r\n\x1a\n", "BM", "\xFF\xD8\xFF"})
    if (begin.starts_with(mark)) return;
  if (!pnm)
    refuse(path,
           "cannot be decoded as a picture: it is neither PNG, TIFF, BMP, JPEG nor PGM; export it as one of "
           "these");
}

void limit_picture_library() {
  // Read when the library is loaded.
  ::setenv("OPENCV_IO_MAX_IMAGE_PIXELS", std::to_string(kMostPixels).c_str(), 1);
}

namespace {

using Read = cv::Mat(const std::string&, int);
using ReadPages = bool(const std::string&, std::vector<cv::Mat>&, int, int, int);
using Encode = bool(const std::string&, cv::InputArray, std::vector<unsigned char>&, const std::vector<int>&);

/// OpenCV has functions of these types under these names, whatever else it has under them.
static_assert(requires {
  static_cast<Read*>(&cv::imread);
  static_cast<ReadPages*>(&cv::imreadmulti);
  static_cast<Encode*>(&cv::imencode);
});

/// OpenCV's imgcodecs. With GDAL behind it, it takes every command a quarter of a second to load, and most
/// touch no picture file: it is loaded by the first that does.
class Imgcodecs {
 public:
  static const Imgcodecs& loaded() {
    static const Imgcodecs functions;
    return functions;
  }
  Read* read = nullptr;
  ReadPages* read_pages = nullptr;
  Encode* encode = nullptr;

 private:
  /// Names as the C++ ABI of GCC and Clang spells them.
  Imgcodecs() {
    const std::string text = "RKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE";
    find("_ZN2cv6imreadE" + text + "i", read);
    find("_ZN2cv11imreadmultiE" + text + "RSt6vectorINS_3MatESaIS9_EEiii", read_pages);
    find("_ZN2cv8imencodeE" + text + "RKNS_11_InputArrayERSt6vectorIhSaIhEERKSB_IiSaIiEE", encode);
  }
  template <class Function>
  void find(const std::string& name, Function*& function) {
    function = handle_ ? reinterpret_cast<Function*>(dlsym(handle_, name.c_str())) : nullptr;
    if (function) return;
    const std::string why = dlerror();
    const bool too_many = why.find(std::strerror(EMFILE)) != std::string::npos;
    throw InputError(
        "picture files need OpenCV's imgcodecs, which cannot be used here: " +
        (too_many ? with_remedy(EMFILE, "")
                  : fmt::format("{}; install Debian's package libopencv-imgcodecs{}", why, version_)));
  }
  std::string version_ = fmt::format("{}{:02}", CV_VERSION_MAJOR, CV_VERSION_MINOR);
  void* handle_ = dlopen(("libopencv_imgcodecs.so." + version_).c_str(), RTLD_LAZY | RTLD_LOCAL);
};

std::vector<unsigned char> encoded(const char* extension, const cv::Mat& image,
                                   const std::vector<int>& parameters) {
  std::vector<unsigned char> bytes;
  Imgcodecs::loaded().encode(extension, image, bytes, parameters);
  return bytes;
}

}  // namespace

void load_picture_library() {
  Imgcodecs::loaded();
}

cv::Mat read_picture(const std::string& file) {
  return Imgcodecs::loaded().read(file, cv::IMREAD_UNCHANGED);
}

std::vector<cv::Mat> read_pages(const std::string& file, int first, int count) {
  std::vector<cv::Mat> pages;
  Imgcodecs::loaded().read_pages(file, pages, first, count, cv::IMREAD_UNCHANGED);
  return pages;
}

std::vector<unsigned char> png_of(const cv::Mat& image) {
  return encoded(".png", image, {});
}

std::vector<unsigned char> tiff_of(const cv::Mat& image) {
  return encoded(".tif", image, {cv::IMWRITE_TIFF_COMPRESSION, 1});
}

std::vector<unsigned char> jpeg_of(const cv::Mat& image, int quality) {
  return encoded(".jpg", image, {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_OPTIMIZE, 1});
}

}  // namespace tribotrack::vision
