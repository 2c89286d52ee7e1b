// Headless Chromium driven by its own protocol over two pipes.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "apps/program.h"

namespace tribotrack::test {

class DrivenBrowser {
 public:
  using Json = nlohmann::json;

  explicit DrivenBrowser(const std::string& program) {
    std::array<int, 2> commands{}, answers{};
    if (pipe(commands.data()) != 0 || pipe(answers.data()) != 0) throw std::runtime_error("no pipe");
    const std::string profile = "--user-data-dir=" + folder_.path().string();
    process_ = fork();
    if (process_ == 0) {
      // Chromium reads commands from 3 and writes answers to 4.
      const int in = fcntl(commands[0], F_DUPFD, 10), out = fcntl(answers[1], F_DUPFD, 10),
                none = open("/dev/null", O_RDWR);
      dup2(in, 3);
      dup2(out, 4);
      for (const int stream : {0, 1, 2}) dup2(none, stream);
      execl(program.c_str(), program.c_str(), "--headless", "--no-sandbox", "--disable-gpu",
            "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking",
            "--disable-component-update", "--disable-sync", "--hide-scrollbars", "--remote-debugging-pipe",
            "--window-size=1280,900", profile.c_str(), "about:blank", nullptr);
      _exit(127);
    }
    close(commands[0]);
    close(answers[1]);
    to_ = commands[1];
    from_ = answers[0];
    const Json targets = call("Target.getTargets", {});
    for (const Json& target : targets["targetInfos"])
      if (target["type"] == "page")
        session_ =
            call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}})["sessionId"];
  }
  ~DrivenBrowser() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    close(to_);
    close(from_);
  }
  DrivenBrowser(const DrivenBrowser&) = delete;
  DrivenBrowser& operator=(const DrivenBrowser&) = delete;

  void open_page(const std::string& url) { call("Page.navigate", {{"url", url}}); }
  /// Until it is loaded.
  void show(const std::string& html) {
    const std::string name = "page" + std::to_string(++shown_) + ".html";
    std::ofstream(folder_.path() / name, std::ios::binary) << html;
    open_page("file://" + (folder_.path() / name).string());
    wait_for("location.href.endsWith('" + name + "') && document.readyState === 'complete'");
  }
  void resize(int width, int height) {
    call("Emulation.setDeviceMetricsOverride",
         {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
  }
  /// The value of a script that may `await`, as JSON; its error where it throws.
  Json value(const std::string& script) {
    const Json answer = call("Runtime.evaluate", {{"expression", "(async () => {" + script + "})()"},
                                                  {"awaitPromise", true},
                                                  {"returnByValue", true}});
    if (answer.contains("exceptionDetails")) return "threw: " + answer["exceptionDetails"].dump();
    return answer["result"].contains("value") ? answer["result"]["value"] : Json();
  }
  /// Until an expression is true; false after so many seconds.
  bool wait_for(const std::string& expression, int seconds = 60) {
    for (int tries = 0; tries < 10 * seconds; ++tries) {
      if (value("return Boolean(" + expression + ")") == true) return true;
      usleep(100'000);
    }
    return false;
  }
  void type(const std::string& text) { call("Input.insertText", {{"text", text}}); }
  void press(const std::string& key) {
    for (const char* kind : {"keyDown", "keyUp"}) {
      Json event = {{"type", kind}, {"key", key}, {"code", key}};
      if (key == "Tab") event["windowsVirtualKeyCode"] = 9;
      if (key == "Enter") event["windowsVirtualKeyCode"] = 13, event["text"] = "\r";
      call("Input.dispatchKeyEvent", event);
    }
  }

 private:
  Json call(const std::string& method, const Json& parameters) {
    Json command = {{"id", ++id_}, {"method", method}, {"params", parameters}};
    if (!session_.empty()) command["sessionId"] = session_;
    const std::string text = command.dump();
    if (write(to_, text.c_str(), text.size() + 1) < 0) throw std::runtime_error("Chromium is gone");
    for (;;) {
      std::size_t end;
      while ((end = heard_.find('\0')) == std::string::npos) {
        std::array<char, 65536> buffer{};
        const ssize_t count = read(from_, buffer.data(), buffer.size());
        if (count <= 0) throw std::runtime_error("Chromium says nothing more");
        heard_.append(buffer.data(), static_cast<std::size_t>(count));
      }
      const Json answer = Json::parse(heard_.substr(0, end));
      heard_.erase(0, end + 1);
      if (answer.value("id", 0) == id_) return answer.contains("result") ? answer["result"] : answer;
    }
  }

  TemporaryFolder folder_;
  int process_ = 0, to_ = -1, from_ = -1, id_ = 0, shown_ = 0;
  std::string session_, heard_;
};

}  // namespace tribotrack::test
