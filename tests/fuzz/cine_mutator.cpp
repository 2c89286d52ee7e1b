// How libFuzzer changes a .cine: field by field. Bytes changed anywhere would hardly ever hit one of its
// offsets, and a wrong one hides everything behind it.
#include <array>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "vision/formats/cine/layout.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

namespace at = tribotrack::vision::cine_layout;

struct Field {
  std::uint64_t place = 0;
  std::size_t bytes = 4;
};

/// The fields of a file, as far as its own offsets lead to them.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> file) : file_(file) {
    for (const auto place : {at::header_size, at::compression, at::version}) add(place, 2);
    for (const auto place : {at::first_movie_image, at::total_image_count, at::first_image_number,
                             at::image_count, at::bitmap_offset, at::setup_offset, at::image_table_offset})
      add(place, 4);
    add(at::trigger_time, 8);
    const std::uint64_t bitmap = number(at::bitmap_offset, 4), setup = number(at::setup_offset, 4);
    add(bitmap, 4);
    for (const auto place :
         {at::bitmap_width, at::bitmap_height, at::bitmap_packing, at::bitmap_image_bytes, at::bitmap_levels})
      add(bitmap + place, 4);
    add(bitmap + at::bitmap_bits, 2);
    for (const auto place : {at::short_rate, at::setup_mark, at::setup_length}) add(setup + place, 2);
    for (const auto place :
         {at::flip_horizontal, at::flip_vertical, at::integer_rate, at::camera_version, at::colour_filter,
          at::real_bits, at::exposure_ns, at::black_level, at::white_level, at::recorded_bits})
      add(setup + place, 4);
    add_blocks(setup + number(setup + at::setup_length, 2));
    add_images();
  }
  const std::vector<Field>& all() const { return fields_; }
  std::uint64_t number(std::uint64_t place, std::size_t bytes) const {
    std::uint64_t value = 0;
    if (place < file_.size() && bytes <= file_.size() - place)
      std::memcpy(&value, file_.data() + place, bytes);
    return value;
  }

 private:
  static constexpr std::uint64_t kMost = 16;  ///< blocks, and images

  void add(std::uint64_t place, std::size_t bytes) {
    if (place < file_.size() && bytes <= file_.size() - place) fields_.push_back({place, bytes});
  }
  void add_blocks(std::uint64_t begin) {
    for (std::uint64_t k = 0; k < kMost && begin < number(at::image_table_offset, 4); ++k) {
      add(begin, 4);
      add(begin + 4, 2);
      for (const std::uint64_t stamp : {0, 1, 2}) add(begin + at::block_head_bytes + 8 * stamp, 8);
      const std::uint64_t size = number(begin, 4);
      if (size < at::block_head_bytes) return;
      begin += size;
    }
  }
  void add_images() {
    const std::size_t entry = number(at::version, 2) == 0 ? 4 : 8;
    const std::uint64_t table = number(at::image_table_offset, 4);
    for (std::uint64_t k = 0; k < std::min(kMost, number(at::image_count, 4)); ++k) {
      add(table + entry * k, entry);
      const std::uint64_t image = number(table + entry * k, entry), annotation = number(image, 4);
      add(image, 4);
      add(image + annotation - 4, 4);
    }
  }

  std::span<const std::uint8_t> file_;
  std::vector<Field> fields_;
};

using Random = std::minstd_rand;

std::uint64_t new_value(const Fields& fields, const Field& field, std::uint64_t file_size, Random& random) {
  constexpr std::array<std::uint64_t, 24> kEdges = {0,
                                                    1,
                                                    2,
                                                    3,
                                                    7,
                                                    8,
                                                    9,
                                                    24,
                                                    40,
                                                    44,
                                                    48,
                                                    256,
                                                    1002,
                                                    1003,
                                                    1024,
                                                    0x7FFF,
                                                    0x8000,
                                                    0xFFFF,
                                                    0x7FFFFFFF,
                                                    0x80000000,
                                                    0xFFFFFFFF,
                                                    0x7FFFFFFFFFFFFFFF,
                                                    0x8000000000000000,
                                                    0xFFFFFFFFFFFFFFFF};
  const std::uint64_t old = fields.number(field.place, field.bytes);
  const std::uint64_t small = random() % 17;
  const Field& other = fields.all()[random() % fields.all().size()];
  switch (random() % 8) {
    case 0:
      return old + small;
    case 1:
      return old - small;
    case 2:
      return file_size + small - 8;
    case 3:
      return fields.number(other.place, other.bytes);
    case 4:
      return other.place;
    case 5:
      return old ^ std::uint64_t{1} << random() % (8 * field.bytes);
    case 6:
      return small;
    default:
      return kEdges[random() % kEdges.size()];
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  Random random(seed);
  if (random() % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  for (unsigned times = 1 + random() % 3; times > 0; --times) {
    const Fields fields({data, size});
    if (fields.all().empty()) return LLVMFuzzerMutate(data, size, max_size);
    const Field& field = fields.all()[random() % fields.all().size()];
    const std::uint64_t value = new_value(fields, field, size, random);
    std::memcpy(data + field.place, &value, field.bytes);
  }
  return size;
}
