// What the process that decodes and its parent say to each other: orders and answers over a socket, frames in
// shared memory.
#pragma once

#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

inline constexpr std::size_t kAhead = 4;  ///< frames in shared memory, the one in use among them

// The parent believes nothing that could lead it out of its own memory.

/// Parent to child: frames from, from + step, ... in places 0, 1, ..., as far as place `end`, not included. A
/// new `series` ends the one before.
struct Order {
  std::int64_t series = 0, from = 0, step = 0, end = 0;
};

enum class Outcome : std::int64_t { done, bad_input, no_memory, other };

/// Child to parent, followed by `length` bytes: of SourceInfo, or what() of an exception.
struct Answer {
  std::int64_t series = 0;
  Outcome outcome = Outcome::done;
  std::uint64_t length = 0;
  // Of a frame, which lies in the shared memory.
  std::int64_t level_bytes = 0, coded_columns = 0, coded_rows = 0;  ///< no columns: no CodedFrame
  std::int64_t coded_type = 0;
};

inline bool send_bytes(int socket, const void* bytes, std::size_t count) {
  const auto* at = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t sent = ::send(socket, at, count, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    count -= static_cast<std::size_t>(sent);
  }
  return true;
}

/// Whether the other end has said something, or has closed.
inline bool has_word(int socket) {
  pollfd end{socket, POLLIN, 0};
  return ::poll(&end, 1, 0) > 0;
}

/// How long receive_bytes() waits for some.
inline void set_patience(int socket, std::uint64_t seconds) {
  const timeval patience{static_cast<time_t>(seconds), 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
}

inline bool receive_bytes(int socket, void* bytes, std::size_t count) {
  auto* at = static_cast<char*>(bytes);
  while (count > 0) {
    const ssize_t got = ::recv(socket, at, count, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Values into a text of bytes, or out of one, in the same order.
class Archive {
 public:
  Archive() = default;
  explicit Archive(std::string written) : bytes_(std::move(written)), reading_(true) {}
  const std::string& bytes() const { return bytes_; }

  template <class T>
  void operator()(T& value) {
    if constexpr (std::is_trivially_copyable_v<T>)
      raw(&value, sizeof value);
    else
      fields(value);
  }

 private:
  void raw(void* value, std::size_t size) {
    if (!reading_) {
      bytes_.append(static_cast<const char*>(value), size);
      return;
    }
    if (size > bytes_.size() - at_) throw InputError("the decoder's answer ends too early");
    std::memcpy(value, bytes_.data() + at_, size);
    at_ += size;
  }
  template <class T>
  static constexpr std::size_t kLeastBytes = std::is_trivially_copyable_v<T> ? sizeof(T) : 1;
  template <class Sequence>
  void sequence(Sequence& values) {
    std::uint64_t count = values.size();
    (*this)(count);
    if (reading_ && count > (bytes_.size() - at_) / kLeastBytes<typename Sequence::value_type>)
      throw InputError("the decoder's answer ends too early");
    values.resize(count);
    for (auto& value : values) (*this)(value);
  }
  void fields(std::string& text) { sequence(text); }
  template <class T>
  void fields(std::vector<T>& values) {
    sequence(values);
  }
  template <class T>
  void fields(std::optional<T>& value) {
    bool there = value.has_value();
    (*this)(there);
    if (!there) return;
    if (reading_) value.emplace();
    (*this)(*value);
  }
  template <class... T>
  void all(T&... values) {
    (..., (*this)(values));
  }
  void fields(Coder& c) {
    all(c.name, c.settings, c.grid, c.all_intra, c.group, c.dead_zone, c.known, c.step);
  }
  void fields(TimeBaseCandidate& c) { all(c.source, c.rate_hz, c.accepted, c.reason); }
  void fields(StampCheck& c) {
    all(c.rate_hz, c.jitter, c.uniform, c.variable, c.stretches, c.missing, c.strays);
  }
  void fields(TimeBase& t) { all(t.rate_hz, t.source, t.stamps_s, t.candidates, t.check); }
  /// All but the path, which the parent knows.
  void fields(SourceInfo& i) {
    all(i.format, i.codec, i.width, i.height, i.bits, i.colour, i.decoded, i.coder, i.frame_count,
        i.first_number, i.numbers, i.time_base, i.exposure_s, i.exposures_s, i.black_level, i.white_level,
        i.pixel_aspect, i.rotation_deg, i.camera, i.trigger_time, i.notes);
  }

  std::string bytes_;
  bool reading_ = false;
  std::size_t at_ = 0;
};

/// Memory that both processes see: kAhead frames, each its levels and how they were coded.
class SharedFrames {
 public:
  SharedFrames(int memory, const SourceInfo& info)
      : levels_(static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height) * sizeof(float)),
        cells_((static_cast<std::size_t>(info.width) / CodedFrame::kCell + 2) *
               (static_cast<std::size_t>(info.height) / CodedFrame::kCell + 2)) {
    void* mapped = ::mmap(nullptr, size(), PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
    if (mapped == MAP_FAILED) throw std::bad_alloc();
    begin_ = static_cast<std::uint8_t*>(mapped);
  }
  ~SharedFrames() { ::munmap(begin_, size()); }
  SharedFrames(const SharedFrames&) = delete;
  SharedFrames& operator=(const SharedFrames&) = delete;

  std::size_t size() const { return kAhead * bytes_of_frame(); }
  std::size_t cells() const { return cells_; }
  std::uint8_t* levels(std::int64_t place) const {
    return begin_ + static_cast<std::size_t>(place) % kAhead * bytes_of_frame();
  }
  std::uint8_t* coded(std::int64_t place) const { return levels(place) + levels_; }

 private:
  std::size_t bytes_of_frame() const { return (levels_ + cells_ * sizeof(CodedCell) + 63) / 64 * 64; }
  std::size_t levels_, cells_;
  std::uint8_t* begin_ = nullptr;
};

}  // namespace tribotrack::vision
