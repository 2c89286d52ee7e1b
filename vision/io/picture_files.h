// Picture files: what they state before anything decodes them, decoding, encoding.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace tribotrack::vision {

/// Throws InputError for a file that is neither PNG, TIFF, BMP, JPEG nor PGM: OpenCV would choose among a
/// dozen decoders by the file's own first bytes, whatever its name; and for a TIFF one of whose pages, or of
/// the tiles they are made of, is beyond vision/io/files.h, or more than so few bytes can hold.
void require_decodable_picture(const std::filesystem::path& file);

// How many pages a TIFF has, and how large they are.

/// Walks the chain of pages (classic and BigTIFF, either byte order). Decoders stop at a broken link and take
/// what came before for the whole file; here it is an InputError, as is a file that is no TIFF.
std::int64_t count_tiff_pages(const std::filesystem::path& path);

// Reading and writing picture files by OpenCV. All throw InputError where its library is not installed.

/// Pictures of more than kMostPixels (vision/io/files.h) are then not decoded, by an environment variable of
/// OpenCV's: before that library is loaded, and while there is one thread.
void limit_picture_library();

/// Loads that library, which the functions below otherwise do when one of them is first called. A process
/// that is forked while another thread loads one cannot.
void load_picture_library();

/// As stored, whatever the depth; empty where it cannot be decoded.
cv::Mat read_picture(const std::string& file);
std::vector<cv::Mat> read_pages(const std::string& file, int first, int count);

/// The bytes of a file that holds a CV_8UC1, CV_16UC1 or CV_8UC3 (B, G, R) picture; of a TIFF not compressed.
std::vector<unsigned char> png_of(const cv::Mat& image);
std::vector<unsigned char> tiff_of(const cv::Mat& image);
/// `quality` 1 to 100 as libjpeg has it.
std::vector<unsigned char> jpeg_of(const cv::Mat& image, int quality);

}  // namespace tribotrack::vision
