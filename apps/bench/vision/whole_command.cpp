#include "apps/bench/vision/whole_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "apps/bench/timing/child_process.h"
#include "apps/bench/timing/paired_timing.h"
#include "apps/bench/vision/circling.h"
#include "apps/bench/vision/recording.h"

namespace tribotrack::bench {

namespace fs = std::filesystem;

namespace {

struct Coding {
  const char* name;
  const char* extension;
};
constexpr Coding kCodings[] = {{"cine", ".cine"}, {"h264", ".mp4"}};

std::string content_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// What a row says of its recording.
struct Case {
  CirclingScene scene;
  int frames = 0;
  double diameter = 0;
  std::string name() const {
    return fmt::format("{}_{:g}px_{}frames_{}x{}", scene.brushed() ? "brushed" : "plain", diameter, frames,
                       scene.scene().width, scene.scene().height);
  }
};

/// The recordings of a case, in every coding; those not kept are removed with it.
class Recordings {
 public:
  Recordings(const Case& of, CirclingRecorder& recorder, const fs::path& keep) : keep_(!keep.empty()) {
    const fs::path folder = keep_ ? keep : temporary_.path();
    fs::create_directories(folder);
    for (const Coding& coding : kCodings) files_.push_back(folder / (of.name() + coding.extension));
    std::vector<fs::path> missing;
    for (const fs::path& file : files_)
      if (!fs::exists(file)) missing.push_back(file);
    if (missing.empty()) return;
    require_room(of, folder);
    recorder.write(of.frames, missing);
  }
  const fs::path& file(std::size_t coding) const { return files_[coding]; }

 private:
  static void require_room(const Case& of, const fs::path& folder) {
    // Uncompressed, and half as much again for its H.264.
    const double needed = 1.5 * of.frames * of.scene.scene().width * of.scene.scene().height;
    const auto there = static_cast<double>(fs::space(folder).available);
    if (there < needed)
      throw vision::InputError(
          fmt::format("{}: {:.1f} GB are free, the recording {} needs {:.1f}; give fewer --frames or another "
                      "folder by --keep",
                      folder.string(), 1e-9 * there, of.name(), 1e-9 * needed));
  }
  TemporaryFolder temporary_;
  bool keep_ = false;
  std::vector<fs::path> files_;
};

/// Read once, so that each of the commands finds it in the system's cache.
void warm(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> block(1 << 20);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size()))) {
  }
}

struct Judged {
  int lost = 0;
  double rms = 0;
};

/// A table with the columns x_px, y_px, and a row for each frame; empty cells where the part is lost.
Judged judge(const fs::path& table, const CirclingScene& scene) {
  std::ifstream stream(table);
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(stream, line);
  const auto names = cells_of(line);
  const auto column = [&](const char* name) {
    const auto at = std::ranges::find(names, name);
    if (at == names.end()) throw std::runtime_error(table.string() + ": has no column " + name);
    return static_cast<std::size_t>(at - names.begin());
  };
  const std::size_t x = column("x_px"), y = column("y_px");
  Judged judged;
  PositionErrors errors(scene);
  for (int frame = 0; std::getline(stream, line); ++frame) {
    const auto cells = cells_of(line);
    if (cells.size() <= std::max(x, y) || cells[x].empty()) {
      ++judged.lost;
      continue;
    }
    errors.see(frame, {std::strtod(cells[x].c_str(), nullptr), std::strtod(cells[y].c_str(), nullptr)});
  }
  judged.rms = errors.rms();
  return judged;
}

/// One of those that take turns.
class Competitor {
 public:
  Competitor(const fs::path& program, std::vector<std::string> arguments, const fs::path& folder,
             const std::string& name)
      : command_(std::move(arguments)), table_(folder / (name + ".csv")), said_(folder / (name + ".txt")) {
    command_.insert(command_.begin(), program.string());
    command_.insert(command_.end(), {"-o", table_.string()});
  }
  void run() {
    const ChildRun run = run_child(command_, said_);
    constexpr int kDone = 0, kQualityGate = 4;  // a lost part is told by its row
    if (run.exit_code != kDone && run.exit_code != kQualityGate)
      throw std::runtime_error(fmt::format("`{}` ended with exit code {}: {}", fmt::join(command_, " "),
                                           run.exit_code, content_of(said_)));
    cpu_.push_back(run.cpu);
    wall_.push_back(run.wall);
    shares_.push_back(shares_from(content_of(said_), run.wall));
  }
  double cpu() const { return median(cpu_); }
  double wall() const { return median(wall_); }
  /// Of the run of median wall time.
  CommandShares shares() const {
    const auto middle = std::ranges::find(wall_, wall());
    return shares_[static_cast<std::size_t>(middle - wall_.begin())];
  }
  const fs::path& table() const { return table_; }
  std::string said() const { return content_of(said_); }

 private:
  std::vector<std::string> command_;
  fs::path table_, said_;
  std::vector<double> cpu_, wall_;
  std::vector<CommandShares> shares_;
};

std::string text_of(const vision::Circle& circle) {
  return fmt::format("{:.6f},{:.6f},{:g}", circle.x, circle.y, circle.radius);
}

/// They take turns until the repetitions or the budget are used up. Returns how often each ran.
int take_turns(const std::vector<Competitor*>& competitors, const WholeCommandOptions& options) {
  constexpr int kLeast = 3;
  const auto begun = std::chrono::steady_clock::now();
  for (int rounds = 0; rounds < options.repetitions; ++rounds) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
    if (rounds >= kLeast && spent.count() * (rounds + 1) / rounds > options.budget_s) return rounds;
    for (Competitor* one : competitors) one->run();
  }
  return options.repetitions;
}

std::vector<WholeCommandRow> bench_file(const fs::path& file, const char* coding, const Case& of,
                                        const WholeCommandOptions& options) {
  const TemporaryFolder folder;
  const std::string mark = text_of(of.scene.mark(0)), part = text_of(of.scene.part(0));
  const auto ours = [&](const char* layers, const char* threads) {
    return Competitor(options.program,
                      {"track", file.string(), "--marker", mark, "--fps", fmt::format("{:g}", kFrameRate),
                       "--fps-reason", "rendered", "--layers", layers, "--threads", threads, "--explain"},
                      folder.path(), std::string(layers) + threads);
  };
  const auto peer = [&](const char* kind) {
    return Competitor(options.program, {"bench-peer", kind, file.string(), "--part", part, "--mark", mark},
                      folder.path(), kind);
  };
  Competitor matching = peer("matching"), reading = peer("reading");
  struct Pair {
    bool layers_off;
    Competitor one, two;
  };
  std::vector<Pair> pairs{{false, ours("auto", "1"), ours("auto", "2")}};
  if (!of.scene.brushed()) pairs.push_back({true, ours("off", "1"), ours("off", "2")});
  std::vector<Competitor*> all{&matching, &reading};
  for (Pair& pair : pairs) all.insert(all.end(), {&pair.one, &pair.two});
  warm(file);
  const int repetitions = take_turns(all, options);
  std::vector<WholeCommandRow> rows;
  for (const Pair& pair : pairs) {
    WholeCommandRow row;
    row.coding = coding;
    row.brushed = of.scene.brushed();
    row.diameter = of.diameter;
    row.width = of.scene.scene().width;
    row.height = of.scene.scene().height;
    row.frames = of.frames;
    row.layers_off = pair.layers_off;
    row.layered = pair.one.said().find("layers: part over platform on ") != std::string::npos;
    row.repetitions = repetitions;
    const Judged judged = judge(pair.one.table(), of.scene);
    row.lost = judged.lost;
    row.rms = judged.rms;
    row.matching_rms = judge(matching.table(), of.scene).rms;
    row.cpu = pair.one.cpu();
    row.wall = pair.one.wall();
    row.wall_two_threads = pair.two.wall();
    row.cpu_two_threads = pair.two.cpu();
    row.matching = matching.cpu();
    row.reading = reading.cpu();
    row.shares = pair.one.shares();
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

WholeCommandOptions quick_whole_command_options() {
  WholeCommandOptions options;
  options.frames = {24};
  options.diameters = {40};
  options.width = 240;
  options.height = 120;
  options.repetitions = 1;
  return options;
}

std::vector<WholeCommandRow> bench_whole_commands(const WholeCommandOptions& options) {
  std::vector<WholeCommandRow> rows;
  const int total =
      static_cast<int>(2 * options.diameters.size() * options.frames.size() * std::size(kCodings));
  int done = 0;
  for (const bool brushed : {false, true})
    for (const double diameter : options.diameters) {
      std::optional<CirclingRecorder> recorder;
      int rendered_width = 0;
      for (const int frames : options.frames) {
        const int divisor = frames > kManyFrames ? 2 : 1;
        const int width = options.width / divisor, height = options.height / divisor;
        const Case of{CirclingScene(width, height, diameter / 2, brushed), frames, diameter};
        if (rendered_width != width) recorder.emplace(of.scene);
        rendered_width = width;
        const Recordings recordings(of, *recorder, options.keep);
        for (std::size_t c = 0; c < std::size(kCodings); ++c) {
          for (WholeCommandRow& row : bench_file(recordings.file(c), kCodings[c].name, of, options))
            rows.push_back(std::move(row));
          if (options.progress) options.progress(++done, total);
        }
      }
    }
  return rows;
}

}  // namespace tribotrack::bench
