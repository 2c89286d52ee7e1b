// Runs a page in headless Chromium, which is cut off from the network, and gives back what became of it.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

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

/// A page, and what is asked of it once it is loaded: a script that may `await`, with `tell(key, value)`,
/// `wait(ms)`, `root`, the page's element, and `dom()`, the page without its scripts.
struct AskedPage {
  std::string name, html, script;
  int width_px = 1200;
};

struct Answers {
  std::map<std::string, std::string> told;  ///< by "NAME.KEY"
  std::string net_log;

  std::string of(const std::string& key) const {
    const auto found = told.find(key);
    return found == told.end() ? "(nothing was told)" : found->second;
  }
};

/// All pages in one run of the browser, in frames of one page.
inline Answers ask(const std::string& program, const std::vector<AskedPage>& pages) {
  const TemporaryFolder folder;
  std::string frames;
  for (const AskedPage& page : pages) {
    std::string html = page.html;
    html.insert(html.rfind("</body>"),
                "<script>addEventListener('load', async () => { const root = document.documentElement;"
                "const tell = (key, value) => parent.postMessage(['" +
                    page.name +
                    ".' + key, String(value)], '*');"
                    "const wait = ms => new Promise(done => setTimeout(done, ms));"
                    "const dom = () => { const copy = root.cloneNode(true);"
                    "copy.querySelectorAll('script').forEach(s => s.remove()); return copy.outerHTML; };"
                    "try {" +
                    page.script + "} catch (error) { tell('failed', error); } });</script>");
    const std::filesystem::path file = folder.path() / (page.name + ".html");
    std::ofstream(file, std::ios::binary) << html;
    frames += "<iframe src='file://" + file.string() +
              "' style='position:absolute;top:0;left:0;border:0' height=6000 width=" +
              std::to_string(page.width_px) + "></iframe>";
  }
  const Browsed browsed = browse(
      program,
      "<html><script>const told = []; addEventListener('message', e => { told.push(e.data);"
      "document.documentElement.dataset.told = encodeURIComponent(JSON.stringify(told)); });</script><body>" +
          frames + "</body></html>",
      "--hide-scrollbars --dump-dom");
  std::string text;
  const std::string coded = root_data(browsed.dom, "told");
  for (std::size_t k = 0; k < coded.size(); ++k) {
    const bool escaped = coded[k] == '%';
    text += escaped ? static_cast<char>(std::stoi(coded.substr(k + 1, 2), nullptr, 16)) : coded[k];
    k += escaped ? 2 : 0;
  }
  Answers answers{{}, browsed.net_log};
  if (!text.empty())
    for (const auto& pair : nlohmann::json::parse(text)) answers.told[pair[0]] = pair[1];
  return answers;
}

inline std::size_t occurrences(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size()))
    ++count;
  return count;
}

}  // namespace tribotrack::test
