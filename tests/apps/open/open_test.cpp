// `open`: its server against whoever is not its page, and its page in a browser, from recordings to a report.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/browser.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

struct Reply {
  int status = 0;
  std::string head, body;
};

/// A small recording of a driven disc beside a mark.
std::string scene(const std::string& shots) {
  return "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = \"pi/2\"\n"
         "[friction]\nmu1 = 0.1\nmu2 = 0.0125\nlag_rad = 0.2\n[run]\ncycles = 8\n"
         "[video]\nwidth = 180\nheight = 160\nframe_rate_hz = 250\nexposure_s = 0.4e-3\n"
         "[camera]\nmm_per_px = 0.15\n[disc]\ndiameter_mm = 6\n[marker]\nposition_px = [30, 30]\nradius_px = "
         "9\n" +
         shots;
}
std::string shot(const std::string& name, int phi, int dtau) {
  return "[[shot]]\nname = \"" + name + "\"\nphi_rad = \"" + std::to_string(phi) + "deg\"\ndtau_rad = \"" +
         std::to_string(dtau) + "deg\"\n";
}

class Open : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    std::filesystem::create_directory(in_folder("lab"));
    put(in_folder("outside.csv"), "secret");
  }
  void TearDown() override {
    if (server_ > 0) {
      EXPECT_EQ(end(SIGTERM), 128 + SIGTERM);
    }
    ProgramTest::TearDown();
  }
  int end(int signal) {
    int status = 0;
    kill(server_, signal);
    waitpid(server_, &status, 0);
    server_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void film(const std::string& shots) {
    put(in_folder("scene.toml"), scene(shots));
    const Outcome made = run("synth scene.toml -q -o lab");
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  void open(const std::string& what = "lab") {
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe(ends.data()), 0);
    server_ = fork();
    if (server_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      if (chdir(folder_.c_str()) == 0)
        execl(TRIBOTRACK_BINARY, "tribotrack", "open", what.c_str(), "--no-browser", "-q", nullptr);
      _exit(127);
    }
    close(ends[1]);
    for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) url_ += c;
    close(ends[0]);
    ASSERT_THAT(url_, testing::MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/[0-9a-f]{32}/"));
    port_ = std::stoi(url_.substr(17));
    secret_ = url_.substr(url_.find('/', 17));
  }
  Reply send(const std::string& method, const std::string& path, const std::string& body = "",
             const std::string& more = "", std::string host = "") const {
    if (host.empty()) host = "127.0.0.1:" + std::to_string(port_);
    const int line = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(port_));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(line, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    const std::string text = method + " " + path + " HTTP/1.1\r\nHost: " + host + "\r\n" + more +
                             "Connection: close\r\nContent-Length: " + std::to_string(body.size()) +
                             "\r\n\r\n" + body;
    EXPECT_EQ(write(line, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    std::string answer;
    std::array<char, 65536> buffer{};
    for (ssize_t count; (count = read(line, buffer.data(), buffer.size())) > 0;)
      answer.append(buffer.data(), static_cast<std::size_t>(count));
    close(line);
    const std::size_t blank = answer.find("\r\n\r\n");
    if (answer.size() < 12 || blank == std::string::npos) return {};
    return {std::stoi(answer.substr(9, 3)), answer.substr(0, blank), answer.substr(blank + 4)};
  }
  Reply get(const std::string& path) const { return send("GET", secret_ + path); }
  Json state() const { return Json::parse(get("state").body); }
  Reply change(Json wanted) const { return send("POST", secret_ + "campaign", wanted.dump()); }
  /// Starts a command and waits for its end.
  Json carry_out(const Json& wanted) const {
    EXPECT_EQ(send("POST", secret_ + "start", wanted.dump()).status, 200);
    for (int tries = 0; tries < 600; ++tries)
      if (const Json job = Json::parse(get("job?seen=-1").body); job["running"] == false)
        return job;
      else
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return {};
  }

  pid_t server_ = 0;
  int port_ = 0;
  std::string url_, secret_;
};

TEST_F(Open, AnswersNobodyButWhoHasItsAddress) {
  put(in_folder("lab/campaign.toml"), "[platform]\n");
  open();
  EXPECT_EQ(get("").status, 200);
  EXPECT_THAT(get("").head,
              AllOf(HasSubstr("frame-ancestors 'none'"), HasSubstr("Referrer-Policy: no-referrer")));
  for (const char* path : {"/", "/state", "/00000000000000000000000000000000/", "/open.js"})
    EXPECT_EQ(send("GET", path).status, 403) << path;
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS"})
    EXPECT_EQ(send(method, "/campaign", "{}").status, 403) << method;
  const std::string port = ":" + std::to_string(port_);
  for (const std::string& host :
       {std::string("evil.example"), "evil.example" + port, std::string("127.0.0.1")})
    EXPECT_EQ(send("GET", secret_, "", "", host).status, 403) << host;
  EXPECT_EQ(send("GET", secret_, "", "", "localhost" + port).status, 200);
  for (const std::string& origin : {std::string("http://evil.example"), std::string("null"),
                                    "https://127.0.0.1" + port, std::string("http://127.0.0.1:1")})
    EXPECT_EQ(send("POST", secret_ + "campaign", "{}", "Origin: " + origin + "\r\n").status, 403) << origin;
  EXPECT_NE(send("POST", secret_ + "campaign", "{}", "Origin: http://127.0.0.1" + port + "\r\n").status, 403);
}

TEST_F(Open, ReadsNothingOutsideItsFolder) {
  film(shot("a", 0, 60));
  std::filesystem::create_directory(in_folder("elsewhere"));
  std::filesystem::rename(in_folder("lab/a.cine"), in_folder("elsewhere/a.cine"));
  std::filesystem::create_symlink(in_folder("elsewhere/a.cine"), in_folder("lab/link.cine"));
  std::filesystem::create_directories(in_folder("lab/campaign-out"));
  std::filesystem::create_symlink(in_folder("outside.csv"), in_folder("lab/campaign-out/link.csv"));
  put(in_folder("lab/campaign-out/runs.csv"), "inside");
  put(in_folder("lab/campaign.toml"), "[platform]\n");
  open();
  EXPECT_EQ(get("out/runs.csv").body, "inside");
  for (const char* path : {"out/../../outside.csv", "out/%2e%2e/%2e%2e/outside.csv", "out/link.csv",
                           "out//etc/passwd", "out/../campaign.toml"})
    EXPECT_THAT(get(path).status, testing::AnyOf(403, 404)) << path;
  for (const char* recording : {"../elsewhere/a.cine", "link.cine", "/etc/passwd", ""})
    for (const char* what : {"frame?recording=", "probe?recording="})
      EXPECT_EQ(get(std::string(what) + recording).status, 400) << what << recording;
  EXPECT_EQ(state()["recordings"], Json::array());
}

TEST_F(Open, AnOlderPageWritesNothing) {
  put(in_folder("lab/campaign.toml"), "# mine\n[platform]\namplitude_mm = 0.28  # by the maker\n");
  open();
  const Json first = state();
  const Json edit = {{"section", "platform"}, {"key", "amplitude_mm"}, {"value", "0.29"}};
  Json wanted = {{"revision", first["revision"]}, {"edits", {edit}}};
  EXPECT_EQ(change(wanted).status, 200);
  const std::string written = content_of(in_folder("lab/campaign.toml"));
  EXPECT_EQ(written, "# mine\n[platform]\namplitude_mm = 0.29  # by the maker\n");
  wanted["edits"][0]["value"] = "0.5";
  EXPECT_EQ(change(wanted).status, 409);
  EXPECT_EQ(content_of(in_folder("lab/campaign.toml")), written);
  wanted["revision"] = state()["revision"];
  wanted["edits"][0]["value"] = "0.5\nx = 1";
  EXPECT_EQ(change(wanted).status, 400);
  EXPECT_EQ(content_of(in_folder("lab/campaign.toml")), written);
  EXPECT_EQ(left_behind().size(), 2u);
}

TEST_F(Open, WhatItIsGivenAndItsPortAreChecked) {
  expect_refused(run("open nowhere --no-browser"), 3, {"nowhere"});
  expect_refused(run("open lab --port 0"), 2, {"--port"});
  std::filesystem::create_directory(in_folder("linked"));
  std::filesystem::create_symlink(in_folder("outside.csv"), in_folder("linked/campaign.toml"));
  expect_refused(run("open linked --no-browser"), 3, {"campaign.toml", "link"});
  open();
  expect_refused(run("open lab --no-browser --port " + std::to_string(port_)), 3, {"--port"});
  EXPECT_EQ(end(SIGINT), 128 + SIGINT);
}

// However it ends.
TEST_F(Open, WhatItStartedEndsWithIt) {
  film(shot("phi000_dtau060", 0, 60) + shot("phi090_dtau060", 90, 60) + shot("phi000_dtau120", 0, 120));
  ASSERT_EQ(run("init lab --from lab --disc-diameter-mm 6 -q").exit_code, 0);
  open();
  EXPECT_EQ(send("POST", secret_ + "start", R"({"what": "run"})").status, 200);
  EXPECT_EQ(send("POST", secret_ + "start", R"({"what": "run"})").status, 409) << "one command at a time";
  const auto at_work = [&] {
    for (const auto& process : std::filesystem::directory_iterator("/proc")) {
      std::error_code gone;
      if (std::filesystem::read_symlink(process.path() / "cwd", gone) == in_folder("lab")) return true;
    }
    return false;
  };
  for (int tries = 0; tries < 100 && !at_work(); ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(at_work());
  end(SIGKILL);
  for (int tries = 0; tries < 100 && at_work(); ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(at_work());
}

using OpenInChromium = Open;

// The whole path with nothing but the page; what it leaves is a campaign that `run` takes to the same
// results.
TEST_F(OpenInChromium, FromAFolderOfRecordingsToAReport) {
  const auto program = test::chromium();
  if (!program) GTEST_SKIP() << "no Chromium";
  film(shot("IMG_2041", 0, 60) + shot("IMG_2042", 90, 60) + shot("IMG_2043", 0, 120) +
       shot("IMG_2044", 200, 90));
  open();
  test::DrivenBrowser browser(*program);
  browser.open_page(url_);
  ASSERT_TRUE(browser.wait_for("document.querySelectorAll('#runs tbody tr').length === 4"));
  browser.value("document.querySelector('[name=diameter_mm]').focus()");
  browser.type("6,0");
  browser.press("Enter");
  ASSERT_TRUE(browser.wait_for("document.querySelectorAll('[data-key=phi_rad]').length === 4"))
      << browser.value("return document.body.innerText");

  // From the spreadsheet, then one value by keyboard alone.
  browser.value("document.getElementById('paste').open = true; document.getElementById('pasted').focus()");
  browser.type(
      "file;phi;dtau\nIMG_2041;0\u00b0;60\u00b0\nimg_2042.cine;90\u00b0;60\u00b0\nIMG_2043;0\u00b0;"
      "120\u00b0\nIMG_2044;20\u00b0;90\u00b0\n");
  browser.press("Tab");
  browser.press("Enter");
  const std::string last = "document.querySelector('[aria-label=\"phi of IMG_2044.cine\"]')";
  ASSERT_TRUE(browser.wait_for(last + " && " + last + ".value === '20deg'"))
      << browser.value("return document.body.innerText");
  browser.value(last + ".focus(); " + last + ".select()");
  browser.type("200\u00b0");
  browser.press("Tab");
  ASSERT_TRUE(browser.wait_for(last + ".value === '200deg'"))
      << browser.value("return document.body.innerText");

  EXPECT_EQ(browser.value("return document.activeElement.getAttribute('aria-label')"),
            "dtau of IMG_2044.cine");

  // A click beside the disc's centre finds the disc.
  ASSERT_TRUE(browser.wait_for("document.documentElement.dataset.probed === '4'"));
  browser.value("location.hash = '#point'");
  ASSERT_TRUE(browser.wait_for("document.querySelectorAll('#point .targets fieldset').length === 5"));
  browser.value(
      "const c = document.querySelector('#point .picture'), b = c.getBoundingClientRect(), d = (await (await "
      "fetch("
      "'probe?recording=IMG_2041.cine')).json()).survey.discs[0].circle_px;"
      "for (const type of ['pointerdown', 'pointerup']) c.dispatchEvent(new PointerEvent(type, {pointerId: "
      "1, bubbles: true,"
      "clientX: b.left + (d[0] + 5) * b.width / 180, clientY: b.top + (d[1] + 3) * b.height / 160}))");
  EXPECT_THAT(browser.value("return document.getElementById('point-lines').textContent").dump(),
              HasSubstr("[camera] disc_px = ["));
  EXPECT_THAT(browser.value("return document.getElementById('point-lines').textContent").dump(),
              HasSubstr(", 20"));

  browser.value("location.hash = '#track'");
  ASSERT_TRUE(browser.wait_for("!document.querySelector('[data-start=first_second]').disabled"));
  browser.value("document.querySelector('[data-start=first_second]').click()");
  ASSERT_TRUE(
      browser.wait_for("document.getElementById('track-numbers').textContent.includes('The first second')"))
      << browser.value("return document.body.innerText");
  EXPECT_THAT(browser.value("return document.getElementById('lost').textContent").dump(), HasSubstr("none"));

  browser.value("location.hash = '#report'");
  browser.value("document.querySelector('[data-start=run]').click()");
  ASSERT_TRUE(browser.wait_for("document.querySelector('#verdict .verdict')", 120))
      << browser.value("return document.body.innerText");
  EXPECT_THAT(browser.value("return document.getElementById('verdict').textContent").dump(),
              HasSubstr("Can be used"));
  EXPECT_EQ(browser.value("return document.documentElement.dataset.errors"), "0")
      << browser.value("return document.documentElement.dataset.errorsText");

  ASSERT_EQ(run("run lab/campaign.toml -o by_hand -q").exit_code, 0);
  EXPECT_EQ(content_of(in_folder("by_hand/fit.json")), content_of(in_folder("lab/campaign-out/fit.json")));
  for (const char* name : {"IMG_2041", "IMG_2044"})
    EXPECT_EQ(content_of(in_folder("by_hand/tracks") / (std::string(name) + ".csv")),
              content_of(in_folder("lab/campaign-out/tracks") / (std::string(name) + ".csv")));

  // While filming: what is there is fitted, what to film next is said, until it is stopped.
  browser.value("document.getElementById('watch').open = true");
  browser.value("document.querySelector('[data-start=watch]').click()");
  EXPECT_TRUE(
      browser.wait_for("document.getElementById('job-lines').textContent.includes('film next: phi = ')", 30))
      << browser.value("return document.body.innerText");
  browser.value("document.getElementById('stop').click()");
  EXPECT_TRUE(browser.wait_for("document.getElementById('stop').textContent === 'Close'"));

  // Every step at the width of a phone and of a desk, by axe-core's rules.
  std::ifstream file(TRIBOTRACK_AXE_JS, std::ios::binary);
  const std::string axe{std::istreambuf_iterator<char>(file), {}};
  browser.value(axe);
  for (const int width : {390, 1280}) {
    browser.resize(width, 900);
    for (const char* step : {"recordings", "point", "track", "check", "report", "file"}) {
      browser.value(std::string("location.hash = '#") + step +
                    "'; await new Promise(done => setTimeout(done, 300))");
      EXPECT_EQ(browser.value("return document.documentElement.scrollWidth <= innerWidth"), true)
          << step << " at " << width;
      EXPECT_EQ(
          browser.value(
              "const r = await axe.run(document, {resultTypes: ['violations'], iframes: false}); return "
              "r.violations.filter(v => v.impact !== 'minor').map(v => v.id + ': ' + v.nodes.map(n => "
              "n.html).join(' ').slice(0, 300)).join('; ')"),
          "")
          << step << " at " << width;
    }
  }
}

}  // namespace
}  // namespace tribotrack::apps
