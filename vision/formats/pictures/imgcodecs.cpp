#include "vision/formats/pictures/imgcodecs.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "vision/io/shared_library.h"

namespace tribotrack::vision {
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

struct Functions {
  Read* read = nullptr;
  ReadPages* read_pages = nullptr;
  Encode* encode = nullptr;
};

/// Their names as the C++ ABI of GCC and Clang spells them.
Functions load() {
  const std::string version = fmt::format("{}{:02}", CV_VERSION_MAJOR, CV_VERSION_MINOR);
  const SharedLibrary library("libopencv_imgcodecs.so." + version, "libopencv-imgcodecs" + version,
                              "picture files");
  Functions functions;
  const std::string text = "RKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE";
  library.find(("_ZN2cv6imreadE" + text + "i").c_str(), functions.read);
  library.find(("_ZN2cv11imreadmultiE" + text + "RSt6vectorINS_3MatESaIS9_EEiii").c_str(),
               functions.read_pages);
  library.find(("_ZN2cv8imencodeE" + text + "RKNS_11_InputArrayERSt6vectorIhSaIhEERKSB_IiSaIiEE").c_str(),
               functions.encode);
  return functions;
}

const Functions& imgcodecs() {
  static const Functions functions = load();
  return functions;
}

}  // namespace

cv::Mat read_picture(const std::string& file) {
  return imgcodecs().read(file, cv::IMREAD_UNCHANGED);
}

std::vector<cv::Mat> read_pages(const std::string& file, int first, int count) {
  std::vector<cv::Mat> pages;
  imgcodecs().read_pages(file, pages, first, count, cv::IMREAD_UNCHANGED);
  return pages;
}

std::vector<unsigned char> tiff_of(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  imgcodecs().encode(".tif", image, bytes, {cv::IMWRITE_TIFF_COMPRESSION, 1});
  return bytes;
}

}  // namespace tribotrack::vision
