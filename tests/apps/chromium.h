// Runs a page in headless Chromium, which is cut off from the network, and gives back what became of it.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

namespace tribotrack::test {

inline std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  char buffer[65536];
  while (const std::size_t n = fread(buffer, 1, sizeof buffer, pipe)) output.append(buffer, n);
  pclose(pipe);
  return output;
}

/// The browser's program, or nullopt where none is installed.
inline std::optional<std::string> chromium() {
  std::string found =
      output_of("command -v chromium || command -v chromium-browser || command -v google-chrome");
  if (found.empty()) return std::nullopt;
  return found.substr(0, found.find('\n'));
}

/// A folder of its own that goes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "tribotrack_report_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// What the scripts made, without the scripts themselves.
inline std::string without_scripts(const std::string& dom) {
  std::string rest;
  std::size_t at = 0;
  while (true) {
    const std::size_t open = dom.find("<script", at);
    rest.append(dom, at, open == std::string::npos ? open : open - at);
    if (open == std::string::npos) return rest;
    at = dom.find("</script>", open);
    if (at == std::string::npos) return rest;
  }
}

struct Browsed {
  std::string dom;      ///< the page after its scripts have run, without the scripts
  std::string net_log;  ///< every request the browser made, as JSON
};

/// `what` is e.g. "--dump-dom" or "--screenshot=file.png". Gives up after two minutes (dom is empty then).
inline Browsed browse(const std::string& program, const std::string& html,
                      const std::string& what = "--dump-dom", int width_px = 1200) {
  const TemporaryFolder folder;
  const std::string place = folder.path().string();
  std::ofstream(folder.path() / "page.html", std::ios::binary) << html;
  Browsed browsed;
  browsed.dom = without_scripts(output_of(
      "timeout -k 5 120 '" + program +
      "' --headless --no-sandbox --disable-gpu --disable-quic --disable-dev-shm-usage --no-first-run"
      " --disable-background-networking --disable-component-update --disable-sync"
      " --disable-default-apps --disable-extensions --host-resolver-rules='MAP * ~NOTFOUND'"
      " --window-size=" +
      std::to_string(width_px) + ",6000 --virtual-time-budget=20000 --user-data-dir='" + place +
      "/profile' --log-net-log='" + place + "/net.json' " + what + " 'file://" + place + "/page.html' 2>'" +
      place + "/stderr'"));
  std::ifstream log(folder.path() / "net.json", std::ios::binary);
  browsed.net_log.assign(std::istreambuf_iterator<char>(log), {});
  return browsed;
}

/// The value of data-<name> on the page's <html> element; empty where there is none.
inline std::string root_data(const std::string& dom, const std::string& name) {
  const std::string key = "data-" + name + "=\"";
  const std::size_t html = dom.find("<html");
  if (html == std::string::npos) return "";
  const std::size_t end = dom.find('>', html);
  const std::size_t at = dom.find(key, html);
  if (at == std::string::npos || at > end) return "";
  return dom.substr(at + key.size(), dom.find('"', at + key.size()) - at - key.size());
}

inline std::size_t occurrences(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size()))
    ++count;
  return count;
}

}  // namespace tribotrack::test
