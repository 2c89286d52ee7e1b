#include "vision/formats/contained/contained.h"

#include <fcntl.h>
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

Answer put_frame(DecodedSource& source, std::int64_t index, const SharedFrames& frames, std::int64_t place) {
  const StoredFrame stored = source.decode(index);
  Answer answer;
  answer.level_bytes = stored.level_bytes;
  const std::size_t row =
      static_cast<std::size_t>(source.info().width) * static_cast<std::size_t>(stored.level_bytes);
  std::uint8_t* to = frames.levels(place);
  for (int y = 0; y < source.info().height; ++y, to += row)
    std::memcpy(to, stored.first + y * stored.row, row);
  const CodedFrame* coded = source.coded();
  if (coded && coded->cells.size() <= frames.cells()) {
    answer.coded_columns = coded->columns;
    answer.coded_rows = coded->rows;
    answer.coded_type = coded->type;
    std::memcpy(frames.coded(place), coded->cells.data(), coded->cells.size() * sizeof(CodedCell));
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

[[noreturn]] void serve(int socket, int memory, const std::filesystem::path& path,
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
  std::optional<SharedFrames> frames;
  Order order;
  for (std::int64_t place = 0;;) {
    const std::int64_t index = order.from + place * order.step;
    if (place >= order.end || index >= source->info().frame_count || has_word(socket)) {
      const std::int64_t series = order.series;
      if (!receive_bytes(socket, &order, sizeof order)) ::_exit(0);
      if (order.series != series) place = 0;
      continue;
    }
    allow_cpu(kSecondsPerFrame);
    answer_with(socket, order.series, [&](std::string&) {
      if (!frames) frames.emplace(memory, source->info());
      return put_frame(*source, index, *frames, place);
    });
    ++place;
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
  Decoder(int memory, const std::filesystem::path& path,
          const std::function<std::unique_ptr<DecodedSource>()>& open) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) fail();
    socket_.emplace(ends[0]);
    const Descriptor of_child(ends[1]);
    process_ = ::fork();
    if (process_ < 0) fail();
    if (process_ > 0) return;
    // Under numbers beyond theirs first: each may have the other's.
    constexpr int kSocket = 3, kMemory = 4, kFirstClosed = 5;
    const int socket = ::fcntl(ends[1], F_DUPFD, kFirstClosed),
              frames = ::fcntl(memory, F_DUPFD, kFirstClosed);
    ::dup2(socket, kSocket);
    ::dup2(frames, kMemory);
    confine_to_reading(kFirstClosed);
    serve(kSocket, kMemory, path, open);
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
      : memory_(::memfd_create("tribotrack", MFD_CLOEXEC | MFD_ALLOW_SEALING)),
        decoder_(memory_.number(), path, open) {
    info_.path = path;
    set_patience(decoder_.socket(), seconds_to_open(path));
    Archive archive(receive(0).second);
    archive(info_);
    const auto of_frames = [&](const auto& values) {
      return values.empty() || std::ssize(values) == info_.frame_count;
    };
    if (info_.width < 1 || info_.height < 1 || info_.frame_count < 1 ||
        std::int64_t{info_.width} * info_.height > kMostPixels || !of_frames(info_.numbers) ||
        !of_frames(info_.exposures_s) || !of_frames(info_.time_base.stamps_s))
      refuse(path, "misleads its decoder; export the recording again");
    set_patience(decoder_.socket(), kSecondsPerFrame);
  }

  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    if (index != held_) fetch(index);
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(info_.width) * level_bytes_;
    copy_stored({frames_->levels(place_), row, level_bytes_, level_bytes_}, window, picture);
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

  /// The next answer of a series, with its bytes.
  std::pair<Answer, std::string> receive(std::int64_t series) {
    constexpr std::uint64_t kMost = std::uint64_t{1} << 31;  // bytes: of stamps of 2^24 frames, a tenth
    for (;;) {
      Answer answer;
      std::string text;
      bool whole = receive_bytes(decoder_.socket(), &answer, sizeof answer) && answer.length < kMost;
      if (whole) {
        text.resize(answer.length);
        whole = receive_bytes(decoder_.socket(), text.data(), text.size());
      }
      if (!whole)
        refuse(info_.path, "{}; it may be damaged: copy or export the recording again",
               end_in_words(decoder_.end()));
      if (answer.series != series) continue;
      switch (answer.outcome) {
        case Outcome::done:
          return {answer, std::move(text)};
        case Outcome::bad_input:
          throw InputError(text);
        case Outcome::no_memory:
          throw std::bad_alloc();
        default:
          throw std::runtime_error(text);
      }
    }
  }

  /// Makes `index` the frame that is held. Where frames are asked for in order, or twice in the same step,
  /// the next ones are ordered with it.
  void fetch(std::int64_t index) {
    if (!frames_) {
      frames_.emplace(memory_.number(), info_);
      const auto size = static_cast<off_t>(frames_->size());
      if (::ftruncate(memory_.number(), size) != 0 ||
          ::fcntl(memory_.number(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
        throw std::bad_alloc();
    }
    const std::int64_t step = held_ < 0 ? 0 : index - held_;
    if (step > 0 && step == order_.step && order_.end > 1) {
      ++place_;
      ++order_.end;
    } else {
      const bool regular = step == 1 || (step > 0 && step == last_step_);
      order_ = {order_.series + 1, index, regular ? step : 0,
                regular ? static_cast<std::int64_t>(kAhead) : 1};
      place_ = 0;
    }
    last_step_ = step;
    held_ = -1;
    send_bytes(decoder_.socket(), &order_, sizeof order_);  // a child that is gone is seen at its answer
    take(receive(order_.series).first, index);
    held_ = index;
  }

  void take(const Answer& answer, std::int64_t index) {
    level_bytes_ =
        answer.level_bytes == 1 || answer.level_bytes == 2 ? static_cast<int>(answer.level_bytes) : 4;
    const std::int64_t columns = answer.coded_columns, rows = answer.coded_rows;
    if (columns < 1 || rows < 1 || columns > info_.width || rows > info_.height || coded(index)) return;
    const auto count = static_cast<std::size_t>(columns * rows);
    if (count > frames_->cells()) return;
    CodedFrame frame{static_cast<char>(answer.coded_type), static_cast<int>(columns), static_cast<int>(rows),
                     std::vector<CodedCell>(count)};
    std::memcpy(frame.cells.data(), frames_->coded(place_), count * sizeof(CodedCell));
    if (coded_.size() == kCodedFrames) coded_.pop_front();
    coded_.push_back({index, std::move(frame)});
  }

  Descriptor memory_;
  Decoder decoder_;
  std::optional<SharedFrames> frames_;
  Order order_;                 ///< the last one
  std::int64_t place_ = 0;      ///< in its series, of the frame that is held
  std::int64_t held_ = -1;      ///< its index
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
