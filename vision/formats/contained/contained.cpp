#include "vision/formats/contained/contained.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <deque>
#include <stdexcept>

#include "vision/formats/contained/confinement.h"
#include "vision/formats/contained/messages.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kCodedFrames = 128;
/// What decoding a frame, and so many bytes of a recording, takes at most: CPU time in the child, waiting in
/// the parent. Opening may read all of a recording, and decode it to see the order of its frames.
constexpr std::uint64_t kSecondsPerFrame = 60, kBytesPerSecond = 1 << 20;

std::uint64_t seconds_to_open(const std::filesystem::path& path) {
  std::error_code not_a_file;
  const std::uint64_t size = std::filesystem::file_size(path, not_a_file);
  return kSecondsPerFrame + (not_a_file ? 0 : size / kBytesPerSecond);
}

// In the child.

Answer put_frame(DecodedSource& source, std::int64_t index, std::string& bytes) {
  const StoredFrame stored = source.decode(index);
  Answer answer;
  answer.level_bytes = stored.level_bytes;
  const std::size_t row =
      static_cast<std::size_t>(source.info().width) * static_cast<std::size_t>(stored.level_bytes);
  for (int y = 0; y < source.info().height; ++y)
    bytes.append(reinterpret_cast<const char*>(stored.first + y * stored.row), row);
  if (const CodedFrame* coded = source.coded()) {
    answer.coded_columns = coded->columns;
    answer.coded_rows = coded->rows;
    answer.coded_type = coded->type;
    bytes.append(reinterpret_cast<const char*>(coded->cells.data()), coded->cells.size() * sizeof(CodedCell));
  }
  return answer;
}

/// What `work` gives, or how it failed, to the parent.
template <class Work>
void answer_with(int socket, std::int64_t series, const Work& work) {
  Answer answer;
  std::string text;
  try {
    answer = work(text);
  } catch (const InputError& error) {
    answer.outcome = Outcome::bad_input;
    text = error.what();
  } catch (const std::bad_alloc&) {
    answer.outcome = Outcome::no_memory;
  } catch (const std::exception& error) {
    answer.outcome = Outcome::other;
    text = error.what();
  }
  answer.series = series;
  answer.length = text.size();
  if (!send_bytes(socket, &answer, sizeof answer) || !send_bytes(socket, text.data(), text.size()))
    ::_exit(0);  // nobody is there any more
}

[[noreturn]] void serve(int socket, const std::filesystem::path& path,
                        const std::function<std::unique_ptr<DecodedSource>()>& open) {
  allow_cpu(seconds_to_open(path));
  std::unique_ptr<DecodedSource> source;
  answer_with(socket, 0, [&](std::string& text) {
    source = open();
    Archive archive;
    SourceInfo info = source->info();
    archive(info);
    text = archive.bytes();
    return Answer{};
  });
  if (!source) ::_exit(0);
  Order order;
  for (std::int64_t next = -1;;) {
    if (next < 0 || next >= source->info().frame_count || has_word(socket)) {
      if (!receive_bytes(socket, &order, sizeof order)) ::_exit(0);
      next = order.from;
      continue;
    }
    allow_cpu(kSecondsPerFrame);
    answer_with(socket, order.series, [&](std::string& bytes) { return put_frame(*source, next, bytes); });
    next = order.step > 0 ? next + order.step : -1;
  }
}

[[noreturn]] void fail() {
  throw InputError(
      fmt::format("no process that decodes can be started: {}; allow more of them (ulimit -u, -n)",
                  std::strerror(errno)));
}

/// A descriptor that is closed.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {
    if (number < 0) fail();
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

/// A process that decodes, at the other end of a socket.
class Decoder {
 public:
  Decoder(const std::filesystem::path& path, const std::function<std::unique_ptr<DecodedSource>()>& open) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) fail();
    socket_.emplace(ends[0]);
    const Descriptor of_child(ends[1]);
    process_ = ::fork();
    if (process_ < 0) fail();
    if (process_ > 0) return;
    constexpr int kSocket = 3;
    ::dup2(ends[1], kSocket);
    confine_to_reading(kSocket + 1);
    serve(kSocket, path, open);
  }
  ~Decoder() { end(); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  int socket() const { return socket_->number(); }

  /// Its status: of its own end, if that came first.
  int end() {
    if (process_ > 0) ::kill(process_, SIGKILL);
    while (process_ > 0 && ::waitpid(process_, &status_, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    return status_;
  }

 private:
  std::optional<Descriptor> socket_;
  pid_t process_ = 0;
  int status_ = 0;
};

class ContainedSource : public FrameSource {
 public:
  ContainedSource(const std::filesystem::path& path,
                  const std::function<std::unique_ptr<DecodedSource>()>& open)
      : decoder_(path, open) {
    info_.path = path;
    set_patience(decoder_.socket(), seconds_to_open(path));
    receive(0);
    Archive archive(std::move(bytes_));
    archive(info_);
    const auto of_frames = [&](const auto& values) {
      return values.empty() || std::ssize(values) == info_.frame_count;
    };
    if (info_.width < 1 || info_.height < 1 || info_.frame_count < 1 ||
        std::int64_t{info_.width} * info_.height > kMostPixels || !of_frames(info_.numbers) ||
        !of_frames(info_.exposures_s) || !of_frames(info_.time_base.stamps_s))
      refuse(path, kMisleads);
    set_patience(decoder_.socket(), kSecondsPerFrame);
  }

  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    if (index != held_) fetch(index);
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(info_.width) * level_bytes_;
    copy_stored({reinterpret_cast<const std::uint8_t*>(bytes_.data()), row, level_bytes_, level_bytes_},
                window, picture);
  }
  const CodedFrame* coded(std::int64_t index) const override {
    const auto found = std::ranges::find(coded_, index, &CodedRecord::index);
    return found == coded_.end() ? nullptr : &found->frame;
  }

 private:
  struct CodedRecord {
    std::int64_t index = 0;
    CodedFrame frame;
  };

  /// The next answer of a series, its bytes in bytes_.
  Answer receive(std::int64_t series) {
    constexpr std::uint64_t kMost = std::uint64_t{1} << 31;  // bytes: of stamps of 2^24 frames, a tenth
    for (;;) {
      Answer answer;
      bool whole = receive_bytes(decoder_.socket(), &answer, sizeof answer) && answer.length < kMost;
      if (whole) {
        bytes_.resize(answer.length);
        whole = receive_bytes(decoder_.socket(), bytes_.data(), bytes_.size());
      }
      if (!whole)
        refuse(info_.path, "{}; it may be damaged: copy or export the recording again",
               end_in_words(decoder_.end()));
      if (answer.series != series) continue;
      switch (answer.outcome) {
        case Outcome::done:
          return answer;
        case Outcome::bad_input:
          throw InputError(bytes_);
        case Outcome::no_memory:
          throw std::bad_alloc();
        default:
          throw std::runtime_error(bytes_);
      }
    }
  }

  /// Makes `index` the frame that is held. Where frames are asked for in order, or twice in the same step,
  /// the next ones are ordered with it.
  void fetch(std::int64_t index) {
    const std::int64_t step = held_ < 0 ? 0 : index - held_;
    if (step <= 0 || step != order_.step) {
      const bool regular = step == 1 || (step > 0 && step == last_step_);
      order_ = {order_.series + 1, index, regular ? step : 0};
      send_bytes(decoder_.socket(), &order_, sizeof order_);  // a child that is gone is seen at its answer
    }
    last_step_ = step;
    held_ = -1;
    take(receive(order_.series), index);
    held_ = index;
  }

  void take(const Answer& answer, std::int64_t index) {
    const std::int64_t columns = answer.coded_columns, rows = answer.coded_rows;
    const bool sensible = (answer.level_bytes == 1 || answer.level_bytes == 2 || answer.level_bytes == 4) &&
                          columns >= 0 && rows >= 0 && columns <= info_.width && rows <= info_.height;
    const std::int64_t of_levels = std::int64_t{info_.width} * info_.height * answer.level_bytes;
    std::vector<CodedCell> cells(sensible ? static_cast<std::size_t>(columns * rows) : 0);
    const std::size_t of_cells = cells.size() * sizeof(CodedCell);
    if (!sensible || bytes_.size() != static_cast<std::size_t>(of_levels) + of_cells)
      refuse(info_.path, kMisleads);
    level_bytes_ = static_cast<int>(answer.level_bytes);
    if (cells.empty() || coded(index)) return;
    std::memcpy(cells.data(), bytes_.data() + of_levels, of_cells);
    if (coded_.size() == kCodedFrames) coded_.pop_front();
    coded_.push_back({index,
                      {static_cast<char>(answer.coded_type), static_cast<int>(columns),
                       static_cast<int>(rows), std::move(cells)}});
  }

  static constexpr const char* kMisleads = "misleads its decoder; export the recording again";

  Decoder decoder_;
  std::string bytes_;           ///< of the last answer: where that is a frame, the one that is held
  Order order_;                 ///< the last one
  std::int64_t held_ = -1;      ///< index of the frame that is held
  std::int64_t last_step_ = 0;  ///< between the last two frames that were asked for
  int level_bytes_ = 1;
  std::deque<CodedRecord> coded_;  ///< of the frames read last
};

}  // namespace

std::unique_ptr<FrameSource> open_contained(const std::filesystem::path& path,
                                            const std::function<std::unique_ptr<DecodedSource>()>& open) {
  return std::make_unique<ContainedSource>(path, open);
}

}  // namespace tribotrack::vision
