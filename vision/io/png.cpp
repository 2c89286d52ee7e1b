#include "vision/io/png.h"

#include <zlib.h>

#include <cstdint>
#include <new>
#include <span>
#include <stdexcept>

namespace tribotrack::vision {
namespace {

using Bytes = std::vector<unsigned char>;

void add_big_endian(Bytes& bytes, std::size_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<unsigned char>(value >> shift));
}

/// Length, name, content, checksum of name and content.
void add_chunk(Bytes& file, const char (&name)[5], std::span<const unsigned char> content) {
  add_big_endian(file, content.size());
  const std::size_t begin = file.size();
  file.insert(file.end(), name, name + 4);
  file.insert(file.end(), content.begin(), content.end());
  add_big_endian(file, crc32_z(0, file.data() + begin, file.size() - begin));
}

/// A row as PNG stores it: R, G, B, or levels whose high byte is first.
void stored_row(const cv::Mat& image, int y, std::span<unsigned char> stored) {
  const unsigned char* row = image.ptr(y);
  if (image.type() == CV_8UC1) {
    std::copy_n(row, stored.size(), stored.begin());
  } else if (image.type() == CV_16UC1) {
    const auto* levels = image.ptr<std::uint16_t>(y);
    for (std::size_t i = 0; i < stored.size(); i += 2) {
      stored[i] = static_cast<unsigned char>(levels[i / 2] >> 8);
      stored[i + 1] = static_cast<unsigned char>(levels[i / 2]);
    }
  } else {
    for (std::size_t i = 0; i < stored.size(); i += 3)
      for (std::size_t c = 0; c < 3; ++c) stored[i + c] = row[i + 2 - c];
  }
}

/// All rows, each after the number of its filter, 1: "less the pixel to the left" (9.2).
Bytes filtered(const cv::Mat& image) {
  const std::size_t pixel = image.elemSize(), width = pixel * static_cast<std::size_t>(image.cols);
  Bytes rows(static_cast<std::size_t>(image.rows) * (width + 1)), stored(width);
  for (int y = 0; y < image.rows; ++y) {
    stored_row(image, y, stored);
    unsigned char* out = rows.data() + static_cast<std::size_t>(y) * (width + 1);
    *out++ = 1;
    for (std::size_t i = 0; i < pixel; ++i) out[i] = stored[i];
    for (std::size_t i = pixel; i < width; ++i)
      out[i] = static_cast<unsigned char>(stored[i] - stored[i - pixel]);
  }
  return rows;
}

Bytes compressed(Bytes& rows) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, MAX_WBITS, 9, Z_RLE) != Z_OK) throw std::bad_alloc();
  Bytes out(deflateBound(&stream, rows.size()));
  stream.next_in = rows.data();
  stream.avail_in = static_cast<uInt>(rows.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);  // cannot fail: the bound is one
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace

std::vector<unsigned char> png_of(const cv::Mat& image) {
  const int type = image.type();
  if (image.empty() || (type != CV_8UC1 && type != CV_16UC1 && type != CV_8UC3))
    throw std::invalid_argument("a PNG is made of 8 or 16 bit grey or of 8 bit colour");
  Bytes header;
  add_big_endian(header, static_cast<std::size_t>(image.cols));
  add_big_endian(header, static_cast<std::size_t>(image.rows));
  const unsigned char depth = type == CV_16UC1 ? 16 : 8, colour = type == CV_8UC3 ? 2 : 0;
  header.insert(header.end(), {depth, colour, 0, 0, 0});  // deflate, its five filters, not interlaced
  Bytes rows = filtered(image);
  Bytes file = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  add_chunk(file, "IHDR", header);
  add_chunk(file, "IDAT", compressed(rows));
  add_chunk(file, "IEND", {});
  return file;
}

}  // namespace tribotrack::vision
