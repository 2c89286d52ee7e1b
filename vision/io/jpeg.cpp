#include "vision/io/jpeg.h"

// libjpeg's header wants these before it.
#include <cstddef>
#include <cstdio>
// clang-format off
#include <jpeglib.h>
// clang-format on
#include <cstdlib>
#include <stdexcept>

namespace tribotrack::vision {
namespace {

/// libjpeg's own handler ends the process.
[[noreturn]] void refuse(j_common_ptr) {
  throw std::runtime_error("a picture could not be coded as JPEG");
}

/// The coder and the memory it writes into, freed however it ends.
struct Coder {
  jpeg_error_mgr errors{};
  jpeg_compress_struct jpeg{};
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  Coder() {
    jpeg.err = jpeg_std_error(&errors);
    errors.error_exit = refuse;
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &size);
  }
  ~Coder() {
    jpeg_destroy_compress(&jpeg);
    std::free(bytes);
  }
  Coder(const Coder&) = delete;
  Coder& operator=(const Coder&) = delete;
};

}  // namespace

std::vector<unsigned char> jpeg_of(const cv::Mat& image, int quality) {
  if (image.type() != CV_8UC1 || image.empty())
    throw std::invalid_argument("jpeg_of: the picture is not one of 8-bit grey levels");
  Coder coder;
  jpeg_compress_struct& jpeg = coder.jpeg;
  jpeg.image_width = static_cast<JDIMENSION>(image.cols);
  jpeg.image_height = static_cast<JDIMENSION>(image.rows);
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg.dct_method = JDCT_ISLOW;  // the same bytes on every processor
  jpeg.optimize_coding = TRUE;
  jpeg_start_compress(&jpeg, TRUE);
  for (int row = 0; row < image.rows; ++row) {
    auto* line = const_cast<unsigned char*>(image.ptr<unsigned char>(row));  // libjpeg reads it only
    jpeg_write_scanlines(&jpeg, &line, 1);
  }
  jpeg_finish_compress(&jpeg);
  return {coder.bytes, coder.bytes + coder.size};
}

}  // namespace tribotrack::vision
