#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <span>

#include "vision/formats/contained/contained.h"
#include "vision/formats/libav/libav.h"
#include "vision/formats/photron/photron.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/kernels/plane.h"
#include "vision/timing/clock.h"

namespace tribotrack::vision {
namespace {

/// What the container states about one packet, in the order of decoding.
struct PacketRecord {
  std::int64_t pts = AV_NOPTS_VALUE;
  std::int64_t dts = AV_NOPTS_VALUE;
  std::int64_t position = -1;  ///< byte in the file
  bool key = false;
  bool shown = true;  ///< false where an edit list leaves the frame out
};

constexpr auto unknown_time = static_cast<std::int64_t>(AV_NOPTS_VALUE);

bool interlaced(const AVFrame& frame) {
#ifdef AV_FRAME_FLAG_INTERLACED  // FFmpeg 6.1 and later
  return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0;
#else
  return frame.interlaced_frame != 0;
#endif
}

const std::uint8_t* display_matrix(const AVStream& stream) {
#if LIBAVFORMAT_VERSION_MAJOR >= 61  // FFmpeg 7 and later
  const AVPacketSideData* data = av_packet_side_data_get(
      stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX);
  return data && data->size >= 9 * sizeof(std::int32_t) ? data->data : nullptr;
#else
  std::size_t size = 0;
  const std::uint8_t* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &size);
  return size >= 9 * sizeof(std::int32_t) ? data : nullptr;
#endif
}

class LibavSource : public DecodedSource {
 public:
  LibavSource(const std::filesystem::path& path, const SourceOptions& options) {
    info_.path = path;
    silence_libav();
    require_whole_matroska();
    open_input();
    list_packets();
    open_input();
    order_frames();
    describe(options);
  }

  StoredFrame decode(std::int64_t index) override {
    decode_frame(shown_[static_cast<std::size_t>(index)], index);
    if (info_.coder) coded_ = coded_frame_of(*decoder_, *frame_, table_step(held_));
    return stored_levels(*frame_, computed_);
  }
  const CodedFrame* coded() const override { return info_.coder ? &coded_ : nullptr; }

 private:
  template <class... Values>
  [[noreturn]] void refuse(fmt::format_string<Values...> clause, Values&&... values) const {
    vision::refuse(info_.path, clause, std::forward<Values>(values)...);
  }
  const AVStream& stream() const { return *input_->streams[stream_index_]; }

  void require_whole_matroska() {
    const std::uint64_t end = matroska_end(info_.path).value_or(0),
                        size = std::filesystem::file_size(info_.path);
    if (end == kUnfinished)
      info_.notes.push_back("the file was never finished by its writer, so frames may be missing at its end");
    else if (end > size)
      refuse(
          "is cut short: its part 'Segment' should end at byte {}, but the file has {} bytes; copy or export "
          "the recording again",
          end, size);
  }

  void open_input() {
    decoder_.reset();
    input_.reset();
    AVFormatContext* context = contained_input();
    const std::string url = "file:" + info_.path.string();
    if (const int error = avformat_open_input(&context, url.c_str(), nullptr, nullptr); error < 0)
      refuse_input(error);
    input_.reset(context);
    if (const int error = find_contained_streams(*context); error < 0) refuse_input(error);
    const AVCodec* codec = nullptr;
    stream_index_ = av_find_best_stream(context, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
    if (stream_index_ == AVERROR_STREAM_NOT_FOUND) refuse("holds no video; name a recording");
    if (stream_index_ < 0 || !codec)
      refuse("holds video in a coding that cannot be decoded here; {}", kRemedyConvert);
    if (!is_coding_read(codec->name))
      refuse("holds video in the coding {}, which is not read; {}", codec->name, kRemedyConvert);
    if (const AVCodecParameters& stated = *stream().codecpar; stated.width != 0 || stated.height != 0)
      require_sensible_size(info_.path, stated.width, stated.height);
    for (unsigned i = 0; i < context->nb_streams; ++i)
      if (static_cast<int>(i) != stream_index_) context->streams[i]->discard = AVDISCARD_ALL;

    decoder_.reset(avcodec_alloc_context3(codec));
    if (!decoder_ || avcodec_parameters_to_context(decoder_.get(), stream().codecpar) < 0)
      refuse("holds video whose parameters cannot be understood; convert it");
    decoder_->thread_count = 1;
    decoder_->err_recognition = AV_EF_CRCCHECK;
    contain(*decoder_);
    ask_for_coding(*decoder_);
    if (const int error = avcodec_open2(decoder_.get(), codec, nullptr); error < 0)
      refuse("cannot be decoded: {}; convert it", libav_error(error));
    next_packet_ = 0;
    draining_ = false;
    held_ = -1;
  }

  /// Why a file cannot be opened, as far as libav tells.
  static std::string reason_of(int error) {
    if (take_libav_complaint().find("moov atom not found") != std::string::npos)
      return ": its index is missing, as when a recording was cut off before it was finished";
    return ": " + libav_error(error);
  }
  [[noreturn]] void refuse_input(int error) const {
    if (error == AVERROR(EINVAL))  // libav's answer to a container that is not on the list
      refuse("is no video of a kind that is read ({}); check the file, or {}", kContainersInWords,
             kRemedyConvert);
    refuse("is no video that can be read{}; check the file, or export it again", reason_of(error));
  }

  /// Reads the next packet of the video; false at the end.
  bool read_packet() {
    for (;;) {
      av_packet_unref(packet_.get());
      const int error = av_read_frame(input_.get(), packet_.get());
      if (error == AVERROR_EOF) return false;
      if (error < 0)
        refuse("cannot be read at packet {}: {}; copy or export the recording again", next_packet_,
               libav_error(error));
      if (packet_->stream_index == stream_index_) return true;
    }
  }

  void list_packets() {
    const std::uint64_t most_bytes = most_packet_bytes(std::filesystem::file_size(info_.path));
    const std::int64_t indexed = index_entries();
    std::uint64_t bytes = 0;
    while (read_packet()) {
      bytes += static_cast<std::uint64_t>(packet_->size);
      if (bytes > most_bytes)
        refuse(
            "is damaged: its first {} frames claim more bytes than the file has; copy or export the "
            "recording again",
            packets_.size() + 1);
      if (packets_.size() == kMostPackets)
        refuse("holds more than {} frames, the most that are read; cut it into parts", kMostPackets);
      if (packet_->flags & AV_PKT_FLAG_CORRUPT)
        refuse("is cut short or damaged at packet {}; copy or export the recording again", packets_.size());
      packets_.push_back({packet_->pts, packet_->dts, packet_->pos, (packet_->flags & AV_PKT_FLAG_KEY) != 0,
                          (packet_->flags & AV_PKT_FLAG_DISCARD) == 0});
      next_packet_ = packets_.size();
    }
    const std::int64_t held = std::ssize(packets_);
    // An AVI's header counts slots; its index, where it has one, lists those that hold a picture.
    const std::int64_t slots = is_avi() ? stream().nb_frames : 0;
    const std::int64_t promised = std::max(index_entries(), indexed < held ? slots : 0);
    if (held < promised)
      refuse("is cut short: it promises {} frames, but holds {}; copy or export the recording again",
             promised, held);
    if (held < slots)
      info_.notes.push_back(
          fmt::format("its header counts {} frames, {} of which hold no picture", slots, slots - held));
    if (packets_.empty()) refuse("holds no frames; export the recording again");
  }
  std::int64_t index_entries() const { return avformat_index_get_entries_count(&stream()); }
  bool is_avi() const { return std::string_view(input_->iformat->name) == "avi"; }

  /// shown_[k] = packet of the k-th frame shown. Stamps give the order; where they are missing or tie and the
  /// coding reorders frames, only decoding shows it.
  void order_frames() {
    const auto time_of = [](const PacketRecord& p) { return p.pts != unknown_time ? p.pts : p.dts; };
    const bool reorders = stream().codecpar->video_delay > 0 || decoder_->has_b_frames > 0;
    for (std::size_t i = 0; i < packets_.size(); ++i)
      if (packets_[i].shown) shown_.push_back(i);
    std::stable_sort(shown_.begin(), shown_.end(), [&](std::size_t a, std::size_t b) {
      return time_of(packets_[a]) < time_of(packets_[b]);
    });
    bool certain = true;
    for (std::size_t k = 0; k < shown_.size(); ++k) {
      const PacketRecord& packet = packets_[shown_[k]];
      if (packet.pts == unknown_time) certain = false;
      if (k > 0 && time_of(packet) == time_of(packets_[shown_[k - 1]])) certain = false;
    }
    if (!certain && !reorders) {
      std::sort(shown_.begin(), shown_.end());
    } else if (!certain) {
      std::vector<std::size_t> order;
      while (next_frame())
        if (held_ >= 0) order.push_back(static_cast<std::size_t>(held_));
      if (order.size() < shown_.size())
        refuse("is damaged: of {} frames only {} can be decoded; export the recording again", shown_.size(),
               order.size());
      shown_ = order;
      open_input();
    }
  }

  /// Decodes the next frame in the order shown into frame_; held_ becomes its packet. False at the end.
  bool next_frame() {
    take_libav_complaint();
    for (;;) {
      const int error = avcodec_receive_frame(decoder_.get(), frame_.get());
      if (error == 0) {
        // These codings hide damage (a wrong checksum) behind an old picture and only log it.
        const AVCodecID codec = decoder_->codec_id;
        if (codec == AV_CODEC_ID_FFV1 || codec == AV_CODEC_ID_MJPEG)
          if (const std::string complaint = take_libav_complaint(); !complaint.empty()) {
            held_ = -1;
            refuse_frame(complaint);
          }
        held_ = is_listed(frame_->pts) ? frame_->pts : -1;
        return true;
      }
      held_ = -1;
      if (error == AVERROR_EOF) return false;
      if (error != AVERROR(EAGAIN)) refuse_frame(libav_error(error));
      if (draining_) return false;
      if (!read_packet()) {
        draining_ = true;
        avcodec_send_packet(decoder_.get(), nullptr);
        continue;
      }
      if (after_seek_) place_after_seek();
      // Decoders hand a packet's time on to its frame: the packet's place in the list identifies it.
      packet_->pts = packet_->dts = static_cast<std::int64_t>(next_packet_);
      packet_->duration = 0;
      if (decoder_->codec_id == AV_CODEC_ID_MJPEG) {
        table_steps_.resize(std::max(table_steps_.size(), next_packet_ + 1));
        table_steps_[next_packet_] = jpeg_step(*packet_);
      }
      ++next_packet_;
      if (const int sent = avcodec_send_packet(decoder_.get(), packet_.get()); sent < 0)
        refuse_frame(libav_error(sent));
    }
  }
  [[noreturn]] void refuse_frame(const std::string& reason) const {
    const std::string packet = fmt::format("packet {} of {}", next_packet_, packets_.size());
    const bool placed = next_packet_ > 0 && next_packet_ <= place_.size() && place_[next_packet_ - 1] >= 0;
    refuse("is damaged: {} cannot be decoded: {}; export the recording again",
           placed ? fmt::format("frame {} ({})", place_[next_packet_ - 1], packet) : packet, reason);
  }

  /// A decoder may make up a frame without a packet, and a file may have grown since its packets were listed.
  bool is_listed(std::int64_t packet) const {
    return packet >= 0 && packet < static_cast<std::int64_t>(packets_.size());
  }

  /// After a seek: which packet of the list is the one just read? -1 in lost_ where that is not certain.
  void place_after_seek() {
    after_seek_ = false;
    const auto same = [&](const PacketRecord& p) {
      return p.pts == packet_->pts && p.dts == packet_->dts && p.position == packet_->pos;
    };
    const auto found = std::find_if(packets_.begin(), packets_.end(), same);
    const bool unique =
        found != packets_.end() && std::find_if(found + 1, packets_.end(), same) == packets_.end();
    if (!unique) throw SeekFailed{};
    next_packet_ = static_cast<std::size_t>(found - packets_.begin());
    if (next_packet_ > seek_target_) throw SeekFailed{};
  }
  struct SeekFailed {};

  /// Brings the frame of packet `wanted` into frame_: onwards from where the decoder is, or from the last key
  /// frame that is decoded and shown before it.
  void decode_frame(std::size_t wanted, std::int64_t index) {
    const auto target = static_cast<std::int64_t>(wanted);
    if (held_ == target) return;
    const std::size_t key = key_before(wanted);
    const bool passed = !(shown_position(held_) < index) || held_ < 0;
    if ((passed && !(held_ < 0 && next_packet_ == 0)) || (key > next_packet_)) seek(key);
    try {
      try_decode(target, index);
    } catch (const SeekFailed&) {
      open_input();
      try_decode(target, index);
    }
    if (frame_->decode_error_flags != 0 || (frame_->flags & AV_FRAME_FLAG_CORRUPT)) {
      held_ = -1;
      refuse("is damaged: frame {} cannot be decoded without errors; export the recording again", index);
    }
    if (frame_->width != info_.width || frame_->height != info_.height || frame_->format != format_) {
      held_ = -1;
      refuse("changes its picture's size or kind at frame {}; all frames of a recording must be alike",
             index);
    }
  }
  void try_decode(std::int64_t target, std::int64_t index) {
    while (next_frame())
      if (held_ == target) return;
    refuse(
        "is cut short or damaged: frame {} (packet {} of {}) cannot be decoded; export the recording again",
        index, target + 1, packets_.size());
  }

  /// The place among the frames shown of the frame of a packet; -1 for none.
  std::int64_t shown_position(std::int64_t packet) const {
    return packet < 0 ? -1 : place_[static_cast<std::size_t>(packet)];
  }

  std::size_t key_before(std::size_t wanted) const {
    for (std::size_t i = wanted + 1; i-- > 0;)
      if (packets_[i].key &&
          shown_position(static_cast<std::int64_t>(i)) <= shown_position(static_cast<std::int64_t>(wanted)))
        return i;
    return 0;
  }

  float table_step(std::int64_t packet) const {
    const auto at = static_cast<std::size_t>(packet);
    return at < table_steps_.size() ? table_steps_[at] : 0;
  }

  /// Every other row of an interlaced frame was filmed half a frame later.
  void require_progressive() const {
    if (interlaced(*frame_))
      refuse(
          "is interlaced: the even and the odd rows of its frames were filmed at different times; film "
          "progressively, or make one picture of each field (ffmpeg -vf bwdif=send_field)");
  }

  void describe_coder() {
    info_.coder = coder_of(*decoder_, *frame_, coded_frame_of(*decoder_, *frame_, table_step(held_)));
    if (!info_.coder) return;
    const auto keys = static_cast<double>(std::ranges::count(packets_, true, &PacketRecord::key));
    const auto frames = static_cast<double>(packets_.size());
    info_.coder->group = frames / std::max(1.0, keys);
    info_.coder->all_intra = keys == frames;
  }

  void seek(std::size_t key) {
    const PacketRecord& packet = packets_[key];
    const std::int64_t time = packet.dts != unknown_time ? packet.dts : packet.pts;
    if (key == 0 || time == unknown_time ||
        av_seek_frame(input_.get(), stream_index_, time, AVSEEK_FLAG_BACKWARD) < 0) {
      open_input();
      return;
    }
    avcodec_flush_buffers(decoder_.get());
    draining_ = false;
    held_ = -1;
    after_seek_ = true;
    seek_target_ = key;
  }

  void describe(const SourceOptions& options) {
    place_.assign(packets_.size(), -1);
    for (std::size_t k = 0; k < shown_.size(); ++k) place_[shown_[k]] = static_cast<std::int64_t>(k);
    info_.format = input_->iformat->name;
    info_.decoded = true;
    info_.codec = avcodec_get_name(stream().codecpar->codec_id);
    info_.frame_count = static_cast<std::int64_t>(shown_.size());
    if (!next_frame()) refuse("holds no frame that can be decoded; export the recording again");
    info_.width = frame_->width;
    info_.height = frame_->height;
    format_ = frame_->format;
    describe_levels();
    require_progressive();
    describe_coder();
    describe_geometry();
    describe_time(options);
  }

  void describe_levels() {
    const AVPixFmtDescriptor* form = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(format_));
    if (!form) refuse("cannot be measured: its pixels are of no known kind");
    if (form->flags & AV_PIX_FMT_FLAG_BAYER)
      refuse(
          "cannot be measured: its pixels are a colour filter mosaic ({}), which is no grey picture; export "
          "it "
          "as grey",
          form->name);
    if (form->flags & (AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_BITSTREAM))
      refuse("cannot be measured: its pixels ({}) are of a kind that is not read; convert it to grey",
             form->name);
    const bool palette = form->flags & AV_PIX_FMT_FLAG_PAL,
               rgb = palette || form->flags & AV_PIX_FMT_FLAG_RGB;
    info_.bits = palette ? 8 : form->comp[0].depth;
    if (rgb && !palette && (form->comp[1].depth != info_.bits || form->comp[2].depth != info_.bits))
      refuse("cannot be measured: its pixels ({}) have colours of different depth; convert it to grey",
             form->name);
    info_.colour = rgb || form->nb_components >= 3;
    info_.codec += fmt::format(" ({})", form->name);
    if (info_.colour)
      info_.notes.push_back(rgb ? "colour turned to luma (0.299 R + 0.587 G + 0.114 B)"
                                : "luma of a colour recording, as stored");
    const bool is_limited =
        info_.colour ? frame_->color_range != AVCOL_RANGE_JPEG : frame_->color_range == AVCOL_RANGE_MPEG;
    if (is_limited && !rgb && info_.bits >= 8) describe_limited_range();
  }

  /// What players do to the pictures before they show them. Here they are as stored.
  void describe_geometry() {
    const AVRational aspect =
        av_guess_sample_aspect_ratio(input_.get(), input_->streams[stream_index_], frame_.get());
    if (aspect.num > 0 && aspect.den > 0) info_.pixel_aspect = av_q2d(aspect);
    const auto* matrix = reinterpret_cast<const std::int32_t*>(display_matrix(stream()));
    if (const AVFrameSideData* own = av_frame_get_side_data(frame_.get(), AV_FRAME_DATA_DISPLAYMATRIX);
        !matrix && own && own->size >= 9 * sizeof(std::int32_t))
      matrix = reinterpret_cast<const std::int32_t*>(own->data);
    if (!matrix) return;
    const double turned = av_display_rotation_get(matrix);
    const bool mirrored = std::int64_t{matrix[0]} * matrix[4] < std::int64_t{matrix[1]} * matrix[3];
    if (std::isfinite(turned)) info_.rotation_deg = static_cast<int>(std::lround(turned));
    if (info_.rotation_deg == 0 && !mirrored) return;
    info_.notes.push_back(
        fmt::format("players show this recording {}turned by {} degrees{}; here x, y and alpha are those of "
                    "the picture as "
                    "it is stored, {} x {} pixels",
                    mirrored ? "mirrored and " : "", std::abs(info_.rotation_deg),
                    info_.rotation_deg < 0 ? " clockwise" : " counter-clockwise", info_.width, info_.height));
  }

  /// Saturated pixels of limited range pile up at white. Some cameras record levels above it as well: where
  /// the first frame has more of those than of white, the recording clips where full range does.
  void describe_limited_range() {
    const int unit = 1 << (info_.bits - 8), black = 16 * unit, white = 235 * unit;
    info_.notes.push_back(fmt::format("limited range: black is stored as {}, white as {}", black, white));
    Picture first(info_.width, info_.height);
    copy_stored(stored_levels(*frame_, computed_), bounds_of(first), first);
    const auto above = static_cast<float>(white + unit), below = static_cast<float>(white - unit);
    std::ptrdiff_t brighter = 0, at_white = 0;
    for (const float level : first.levels()) {
      brighter += level > above;
      at_white += level >= below && level <= above;
    }
    if (brighter > at_white) {
      info_.notes.push_back("levels above white occur: pixels clip at the largest level");
      return;
    }
    info_.black_level = black;
    info_.white_level = white;
  }

  void describe_time(const SourceOptions& options) {
    ClockEvidence evidence;
    if (const auto sidecar = photron_sidecar(info_.path))
      read_photron_sidecar(*sidecar).describe(info_, evidence.camera);
    if (auto tag = capture_tag()) evidence.camera.push_back(*tag);
    for (const std::size_t packet : shown_)
      evidence.ticks.push_back(packets_[packet].pts != unknown_time ? packets_[packet].pts
                                                                    : packets_[packet].dts);
    // Where frames are reordered and stamps tie, the stamps in order are still those of the frames in order.
    std::ranges::sort(evidence.ticks);
    if (evidence.ticks.front() == unknown_time) std::ranges::fill(evidence.ticks, 0);
    evidence.tick_s = av_q2d(stream().time_base);
    evidence.stated_rate_hz = av_q2d_or_zero(stream().avg_frame_rate);
    evidence.slots = is_avi();
    info_.time_base = judge_time(evidence, options, info_.first_number, info_.notes);
  }
  static double av_q2d_or_zero(AVRational rate) { return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0; }

  std::optional<TimeBaseCandidate> capture_tag() const {
    constexpr const char* name = "com.android.capture.fps";
    for (const AVDictionary* tags : {input_->metadata, stream().metadata}) {
      const AVDictionaryEntry* tag = av_dict_get(tags, name, nullptr, 0);
      if (!tag) continue;
      const double rate = std::strtod(tag->value, nullptr);
      if (rate > 0 && rate < 1e9)
        return TimeBaseCandidate{std::string("tag ") + name, rate, true, "written by the camera"};
      return TimeBaseCandidate{std::string("tag ") + name, 0, false,
                               std::string("'") + tag->value + "' is no rate"};
    }
    return std::nullopt;
  }

  LibavInput input_;
  LibavCoder decoder_;
  LibavPacket packet_{there(av_packet_alloc())};
  LibavFrame frame_{there(av_frame_alloc())};
  int stream_index_ = -1;
  int format_ = -1;
  std::vector<PacketRecord> packets_;  ///< in the order of decoding
  std::vector<std::size_t> shown_;     ///< packet of each frame, in the order shown
  std::vector<std::int64_t> place_;    ///< inverse of shown_, -1 where not shown
  std::size_t next_packet_ = 0;        ///< place in the list of the packet that is read next
  std::int64_t held_ = -1;             ///< packet whose frame is in frame_
  bool draining_ = false;
  bool after_seek_ = false;
  std::size_t seek_target_ = 0;

  Picture computed_;                ///< levels of the frame that was decoded last, where they are not stored
  CodedFrame coded_;                ///< how that frame was
  std::vector<float> table_steps_;  ///< of each packet decoded, MJPEG
};

}  // namespace

std::unique_ptr<FrameSource> open_libav(const std::filesystem::path& path, const SourceOptions& options) {
  return open_contained(path, [&] { return std::make_unique<LibavSource>(path, options); });
}

}  // namespace tribotrack::vision
