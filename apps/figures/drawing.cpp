// Figures made ready to be drawn: ranges, ticks and thinned paths; and the files for print.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>

#include "apps/figures/axes.h"
#include "apps/figures/printed.h"
#include "apps/program/errors.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMostTicks = 8.5;

/// Do all values lie on multiples of pi/n?
bool lie_on(const std::vector<double>& values, long n) {
  return std::ranges::all_of(values, [&](double v) {
    const double k = v * static_cast<double>(n) / kPi;
    return !std::isfinite(v) || std::abs(k - std::round(k)) < 1e-3;
  });
}

void extend(Range& range, bool& any, double value) {
  if (!std::isfinite(value)) return;
  range = any ? Range{std::min(range.low, value), std::max(range.high, value)} : Range{value, value};
  any = true;
}

/// What the series of a panel reach along one axis.
void add_reach(const FigurePanel& panel, bool along_x, AxisScale scale, Range& range, bool& any) {
  const auto add = [&](double value) {
    if (scale == AxisScale::linear || value > 0) extend(range, any, value);
  };
  for (const Series& series : panel.series) {
    const std::vector<double>& values = along_x ? series.x : series.y;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double bar = !along_x && i < series.sd.size() && std::isfinite(series.sd[i]) ? series.sd[i] : 0;
      add(values[i] - bar);
      add(values[i] + bar);
    }
    if (!along_x)
      for (const double value : series.y_high) add(value);
    if (along_x && series.mark == Mark::bars) add(0);
  }
}

void settle(FigureAxis& axis, const Range& reach, bool any) {
  Range ends = any ? reach : Range{};
  if (axis.scale == AxisScale::logarithmic) {
    const auto decade = [](double value, bool up) {
      const double power = std::log10(value);
      return std::pow(10, up ? std::ceil(power - 1e-9) : std::floor(power + 1e-9));
    };
    ends = any ? Range{decade(reach.low, false), decade(reach.high, true)} : Range{1, 10};
    if (!(ends.high > ends.low)) ends.high = 10 * ends.low;
  } else {
    if (!(ends.high > ends.low)) {
      const double spare = std::max(0.5 * std::abs(ends.low), 1e-9);
      ends = {ends.low - spare, ends.high + spare};
    }
    ends = padded(ends, 0.05);
  }
  if (std::isnan(axis.low)) axis.low = ends.low;
  if (std::isnan(axis.high)) axis.high = ends.high;
}

}  // namespace

std::string multiple_of_pi(long k, long n) {
  if (k == 0) return "0";
  const long divisor = std::gcd(k, n), top = std::abs(k) / divisor, bottom = n / divisor;
  return (k < 0 ? "−" : "") + (top == 1 ? std::string() : std::to_string(top)) + "π" +
         (bottom == 1 ? std::string() : "/" + std::to_string(bottom));
}

FigureAxis angle_axis(const std::string& title, double low, double high, const std::vector<double>& values) {
  FigureAxis axis{.title = title, .low = low, .high = high};
  constexpr std::array<long, 5> quarters = {12, 8, 4, 2, 1};
  constexpr std::array<long, 5> thirds = {12, 6, 3, 2, 1};
  const double turns = (high - low) / kPi;
  for (const long n : lie_on(values, 4) || !lie_on(values, 6) ? quarters : thirds) {
    if (turns * static_cast<double>(n) > kMostTicks && n > 1) continue;
    const double step = kPi / static_cast<double>(n);
    for (long k = std::lround(std::ceil(low / step - 1e-9)); static_cast<double>(k) * step <= high + 1e-9;
         ++k) {
      axis.ticks.push_back(static_cast<double>(k) * step);
      axis.labels.push_back(multiple_of_pi(k, n));
    }
    break;
  }
  if (axis.ticks.size() >= 3) return axis;
  axis.ticks.clear();
  axis.labels.clear();
  return axis;
}

Range range_of(const std::vector<double>& values) {
  Range range;
  bool any = false;
  for (const double value : values) extend(range, any, value);
  if (!any) return {};
  if (!(range.high > range.low)) range.high = range.low + std::max(std::abs(range.low), 1e-3);
  return range;
}

Range padded(const Range& range, double share) {
  return {range.low - share * range.size(), range.high + share * range.size()};
}

Range hull(const Range& a, const Range& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

void settle_axes(Figure& figure) {
  const auto columns = static_cast<std::size_t>(figure.columns);
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    FigurePanel& panel = figure.panels[i];
    Range reach;
    bool any = false;
    add_reach(panel, false, panel.y.scale, reach, any);
    for (const Stripe& stripe : panel.stripes)
      for (const double end : {stripe.low, stripe.high}) extend(reach, any, end);
    if (panel.zero_line) extend(reach, any, 0);
    settle(panel.y, reach, any);
    any = false;
    for (std::size_t k = 0; k < figure.panels.size(); ++k)
      if (k == i || (figure.shared_x && k % columns == i % columns))
        add_reach(figure.panels[k], true, panel.x.scale, reach, any);
    settle(panel.x, reach, any);
  }
}

DrawnPath thinned(const std::vector<double>& x, const std::vector<double>& y, std::size_t most) {
  constexpr double pen_up = std::numeric_limits<double>::quiet_NaN();
  const std::size_t count = std::min(x.size(), y.size());
  const std::size_t step = std::max<std::size_t>(1, (count + most - 1) / most);
  DrawnPath path;
  const auto add = [&](double px, double py) {
    path.x.push_back(px);
    path.y.push_back(py);
  };
  bool gap = false;
  for (std::size_t i = 0; i < count; ++i) {
    const bool measured = std::isfinite(x[i]) && std::isfinite(y[i]);
    gap = gap || !measured;
    if (i % step != 0) continue;
    if (gap) add(pen_up, pen_up);
    if (measured) add(x[i], y[i]);
    gap = false;
  }
  return path;
}

std::vector<std::size_t> envelope(const std::vector<double>& y, std::size_t most) {
  std::vector<std::size_t> places;
  if (y.size() <= most) {
    places.resize(y.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    return places;
  }
  const std::size_t stretches = std::max<std::size_t>(1, most / 2);
  for (std::size_t k = 0; k < stretches; ++k) {
    const std::size_t begin = k * y.size() / stretches, end = (k + 1) * y.size() / stretches;
    std::size_t lowest = begin, highest = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(y[i])) continue;
      if (!std::isfinite(y[lowest]) || y[i] < y[lowest]) lowest = i;
      if (!std::isfinite(y[highest]) || y[i] > y[highest]) highest = i;
    }
    places.push_back(std::min(lowest, highest));
    if (lowest != highest) places.push_back(std::max(lowest, highest));
  }
  return places;
}

std::vector<double> picked(const std::vector<double>& values, const std::vector<std::size_t>& places) {
  std::vector<double> chosen;
  chosen.reserve(places.size());
  for (const std::size_t place : places)
    chosen.push_back(place < values.size() ? values[place] : std::numeric_limits<double>::quiet_NaN());
  return chosen;
}

namespace fs = std::filesystem;

namespace {

constexpr const char* kInterpreter = "/usr/bin/python3";  // Debian's, whose packages hold matplotlib

/// A folder for what matplotlib keeps, gone with this object.
struct Scratch {
  std::string path = (fs::temp_directory_path() / "tribotrack_XXXXXX").string();
  Scratch() {
    if (::mkdtemp(path.data()) == nullptr) throw InvalidInput(path + ": the folder cannot be made");
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
};

/// Runs the script as Debian's python3 does, with nothing of the user's settings, of the current folder or of
/// the script's own: a json.py or matplotlibrc that lies there is not what it reads. What it says; its
/// status, 127 where there is no python3.
std::string run_script(std::string script, int& status) {
  const Scratch scratch;
  const std::string said = scratch.path + "/said";
  std::string interpreter = kInterpreter, isolated = "-I", no_cache = "-B", home = "HOME=" + scratch.path,
              settings = "MPLCONFIGDIR=" + scratch.path, letters = "LC_ALL=C.UTF-8";
  char* const arguments[] = {interpreter.data(), isolated.data(), no_cache.data(), script.data(), nullptr};
  char* const environment[] = {home.data(), settings.data(), letters.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, said.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  posix_spawn_file_actions_addchdir_np(&actions, scratch.path.c_str());
  pid_t child = 0;
  const int failed = posix_spawn(&child, kInterpreter, &actions, nullptr, arguments, environment);
  posix_spawn_file_actions_destroy(&actions);
  status = 127;
  if (failed != 0) return fmt::format("{} cannot be started", kInterpreter);
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  status = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  return fs::exists(said) ? read_text(said) : "";
}

/// The last line that says something.
std::string last_line(const std::string& text) {
  const auto end = text.find_last_not_of(" \n");
  if (end == std::string::npos) return "the plotting program failed";
  const auto begin = text.rfind('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
}

}  // namespace

std::vector<fs::path> printed_files(const fs::path& folder) {
  std::vector<fs::path> files = {folder / "figures.py", folder / "runs.csv"};
  for (const char* name : {"alpha-phi", "alpha-dtau", "v-phi", "v-dtau", "residuals"})
    for (const char* ending : {"-84mm.svg", "-84mm.pdf", "-174mm.svg", "-174mm.pdf"})
      files.push_back(folder / (std::string(name) + ending));
  return files;
}

void print_figures(const fs::path& folder, std::string_view runs_csv, std::string_view script) {
  create_folder(folder);
  const std::string path = fs::absolute(folder / "figures.py").string();
  write_file(path, script);
  write_file(folder / "runs.csv", runs_csv);
  int status = 0;
  const std::string said = run_script(path, status);
  if (status == 0) return;
  const bool missing = status == 127 || said.find("ModuleNotFoundError") != std::string::npos;
  throw InvalidInput(fmt::format(
      "{}: the figures were not drawn: {}; {} (table and script are there)", folder.string(), last_line(said),
      missing ? fmt::format("install Debian's python3-matplotlib, then `python3 {}` draws them", path)
              : fmt::format("`python3 {}` says more", path)));
}

}  // namespace tribotrack::apps
