// Wrong inputs and faults, tried as a user would: each row of the tables beside this file says what is given,
// what is typed, and what the program must answer. Laws that hold for every answer are checked here once.
#include <fcntl.h>
#include <fnmatch.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <toml++/toml.h>
#include <array>
#include <chrono>
#include <map>
#include <regex>
#include <set>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

namespace fs = std::filesystem;

/// One row.
struct Trial {
  std::string id, what;
  std::string given;  ///< shell commands that make the inputs, in a copy of the prepared folder
  std::string typed;  ///< what the user types: shell, with `tribotrack` on the path
  int exit_code = 0;
  std::vector<std::string> says;     ///< must stand in stderr
  std::vector<std::string> prints;   ///< must stand in stdout
  std::vector<std::string> never;    ///< must stand in neither
  std::vector<std::string> changes;  ///< shell patterns of files that may be changed or removed
  std::vector<std::string> makes;    ///< shell patterns of files that a refused command may leave
  std::string then;                  ///< shell commands that must succeed afterwards
  bool talks = false;                ///< more than the one sentence of a refusal
  std::string needs;                 ///< a shell condition without which the row is skipped (root, a tool)
  std::string falls_short;           ///< what is missing where the answer is right but not good
};

void PrintTo(const Trial& trial, std::ostream* to) {
  *to << trial.what;
}

std::vector<std::string> texts_of(const toml::table& row, const char* key) {
  std::vector<std::string> texts;
  if (const toml::array* list = row[key].as_array())
    for (const toml::node& text : *list) texts.push_back(text.value<std::string>().value());
  return texts;
}

Trial trial_of(const toml::table& row) {
  static const std::set<std::string> kKnown = {"id",   "what",   "given", "typed",      "exit",
                                               "says", "prints", "never", "changes",    "makes",
                                               "then", "talks",  "needs", "falls_short"};
  for (const auto& [key, value] : row)
    if (!kKnown.contains(std::string(key.str())))
      throw std::runtime_error("unknown key " + std::string(key.str()));
  const auto text = [&](const char* key) { return row[key].value_or(std::string()); };
  Trial trial;
  trial.id = text("id");
  trial.what = text("what");
  trial.given = text("given");
  trial.typed = text("typed");
  trial.exit_code = row["exit"].value<int>().value();
  trial.says = texts_of(row, "says");
  trial.prints = texts_of(row, "prints");
  trial.never = texts_of(row, "never");
  trial.changes = texts_of(row, "changes");
  trial.makes = texts_of(row, "makes");
  trial.then = text("then");
  trial.talks = row["talks"].value_or(false);
  trial.needs = text("needs");
  trial.falls_short = text("falls_short");
  return trial;
}

fs::path tables() {
  return fs::path(TRIBOTRACK_SOURCE_DIR) / "tests/apps/trials";
}

std::vector<Trial> all_trials() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(tables() / "tables")) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Trial> trials;
  for (const fs::path& file : files) {
    const toml::table table = toml::parse_file(file.string());
    for (const toml::node& row : *table["trial"].as_array()) trials.push_back(trial_of(*row.as_table()));
  }
  return trials;
}

/// Runs a shell script in a folder; everything it prints goes to the two named files.
int shell(const fs::path& folder, const std::string& script, const fs::path& out, const fs::path& err) {
  const fs::path file = out.string() + ".sh";
  put(file, "cd '" + folder.string() + "'\n" + script);
  const std::string binary_folder = fs::path(TRIBOTRACK_BINARY).parent_path().string();
  const std::string command = "LC_ALL=C.UTF-8 TERM=xterm PATH='" + binary_folder + "':$PATH SRC='" +
                              TRIBOTRACK_SOURCE_DIR + "' timeout -k 5 120 bash '" + file.string() + "' >'" +
                              out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(command.c_str());
  fs::remove(file);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// A finished small campaign: c.toml, its recordings in rec/, the result of `run` in out/. Made once for this
/// build of the program, by whichever test comes first.
fs::path prepared_folder() {
  const fs::path folder = fs::path(TRIBOTRACK_BINARY_DIR) / "trials";
  fs::create_directories(folder);
  const int lock = ::open((folder / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
  ::flock(lock, LOCK_EX);
  const fs::path small = folder / "small";
  std::error_code missing;
  const auto made = fs::last_write_time(small / "done", missing);
  bool current = !missing;
  for (const fs::path& source : {fs::path(TRIBOTRACK_BINARY), tables() / "scene.toml", tables() / "c.toml"})
    current = current && fs::last_write_time(source) < made;
  if (!current) {
    fs::remove_all(small);
    fs::create_directories(small);
    fs::copy_file(tables() / "c.toml", small / "c.toml");
    const int failed = shell(small,
                             "set -e\n"
                             "tribotrack synth '" +
                                 (tables() / "scene.toml").string() +
                                 "' -o rec -q\n"
                                 "tribotrack run c.toml -o out -q\n",
                             folder / "out.txt", folder / "err.txt");
    if (failed == 0) put(small / "done", "");
    EXPECT_EQ(failed, 0) << content_of(folder / "err.txt");
  }
  ::close(lock);
  return small;
}

/// What can be used in `given`, `typed` and `then`.
const std::string kPrelude = R"sh(
line() { sed -i "$1s|.*|$2|" c.toml; }              # line NUMBER TEXT: replaces a line of the campaign
add() { printf '%s\n' "$@" >>c.toml; }              # add LINE...: at its end
edit() { sed -i -E "$@"; }
fit() { tribotrack fit c.toml --tracks out/tracks -o f.json "$@"; }
run() { tribotrack run c.toml -o o "$@"; }
track() { tribotrack track rec/a.cine --disc-diameter-mm 6 -o t.csv "$@"; }
measure() { tribotrack measure a.csv "$@"; }
a_track() { cp out/tracks/a.csv . && cp out/tracks/a.csv.meta.json .; }
rate=(--fps 250)
# trace FILE PHI DTAU [W]: half a second of an oscilloscope, a sensor's pulses on CH1, bursts of 5890 Hz on CH2.
trace() {
  awk -v phi="$2" -v dtau="$3" -v w="${4:-62.8}" 'BEGIN {
    turn = 8 * atan2(1, 1)
    print "Time(s),CH1(V),CH2(V)"
    for (i = 0; i < 25000; ++i) {
      t = i / 50000
      since = w * t - phi + turn
      since -= turn * int(since / turn)
      printf "%.5f,%.3f,%.3f\n", t, (w * t / turn) % 1 < 0.05 ? 5 : 0, since < dtau ? 9 * sin(turn * 5890 * t) : 0
    }
  }' >"$1"
}
)sh";

struct FileState {
  std::uintmax_t size = 0;
  fs::file_time_type changed;
  ::ino_t inode = 0;
  bool operator==(const FileState&) const = default;
};

std::map<std::string, FileState> files_in(const fs::path& folder) {
  std::map<std::string, FileState> files;
  for (const auto& entry :
       fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
    struct stat status {};
    if (::lstat(entry.path().c_str(), &status) != 0 || S_ISDIR(status.st_mode)) continue;
    FileState state;
    state.inode = status.st_ino;
    if (S_ISREG(status.st_mode)) {
      state.size = static_cast<std::uintmax_t>(status.st_size);
      state.changed = fs::last_write_time(entry.path());
    }
    files[fs::relative(entry.path(), folder).string()] = state;
  }
  return files;
}

bool matches(const std::string& name, const std::vector<std::string>& patterns) {
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return ::fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
  });
}

/// Words of libraries, of the standard library and of debuggers, which tell a user nothing.
constexpr std::array<const char*, 16> kLibraryWords = {"json.exception",
                                                       "Encountered invalid utf-8",
                                                       "Error while parsing",
                                                       "saw '",
                                                       "basic_string",
                                                       "std::",
                                                       "what():",
                                                       "_M_range_check",
                                                       "Invalid data found",
                                                       "moov",
                                                       "OpenCV(",
                                                       "CLI::",
                                                       "not in range",
                                                       "FAILED",
                                                       "terminate called",
                                                       "stoi"};

class Trials : public ::testing::TestWithParam<Trial> {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tribotrack-trial-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    root_ = name;
    folder_ = root_ / "trial";
    fs::copy(prepared_folder(), folder_, fs::copy_options::recursive);
    fs::remove(folder_ / "done");
  }
  void TearDown() override {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  int shell_here(const std::string& script) const {
    return shell(folder_, kPrelude + script, root_ / "out.txt", root_ / "err.txt");
  }
  std::string out() const { return content_of(root_ / "out.txt"); }
  /// Without the progress that work of more than 10 s shows, as on a busy machine.
  std::string err() const {
    static const std::regex progress("[a-z, ]+: [0-9]+/[0-9]+ \\([0-9]+ %\\)[^\n]*\n");
    return std::regex_replace(content_of(root_ / "err.txt"), progress, "");
  }

  fs::path root_, folder_;
};

TEST_P(Trials, GetsAnAnswerThatHelps) {
  const Trial& trial = GetParam();
  if (!trial.needs.empty() && shell_here(trial.needs) != 0) GTEST_SKIP() << trial.needs;
  ASSERT_EQ(shell_here("set -eu\n" + trial.given), 0) << err();
  const auto before = files_in(folder_);
  const int exit_code = shell_here(trial.typed);
  const std::string out = this->out(), err = this->err();
  SCOPED_TRACE(trial.id + ", " + trial.what + "\n" + trial.typed + "\nstdout: " + out.substr(0, 2000) +
               "\nstderr: " + err.substr(0, 4000));

  EXPECT_EQ(exit_code, trial.exit_code) << (exit_code == 124 ? "it hangs" : "");
  using ::testing::HasSubstr;
  for (const std::string& word : trial.says) EXPECT_THAT(err, HasSubstr(word));
  for (const std::string& word : trial.prints) EXPECT_THAT(out, HasSubstr(word));
  for (const std::string& word : trial.never) EXPECT_THAT(out + err, ::testing::Not(HasSubstr(word)));
  for (const char* word : kLibraryWords) EXPECT_THAT(out + err, ::testing::Not(HasSubstr(word)));

  // A refusal is one sentence, and nothing else.
  const bool refused = trial.exit_code == kUsage || trial.exit_code == kInvalidInput;
  if (refused && !trial.talks) {
    EXPECT_EQ(out, "");
    EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1);
    EXPECT_TRUE(err.starts_with("tribotrack: "));
  }

  // What was there is as it was; what failed leaves nothing.
  const auto after = files_in(folder_);
  for (const auto& [name, state] : before) {
    if (matches(name, trial.changes)) continue;
    const auto now = after.find(name);
    EXPECT_TRUE(now != after.end()) << name << " is gone";
    EXPECT_TRUE(now == after.end() || now->second == state) << name << " was changed";
  }
  for (const auto& [name, state] : after) {
    EXPECT_EQ(name.find(".partial-"), std::string::npos) << name << " was left";
    EXPECT_TRUE(!refused || before.contains(name) || matches(name, trial.makes)) << name << " was left";
  }
  if (trial.then.empty()) return;
  EXPECT_EQ(shell_here("set -e\n" + trial.then), 0) << trial.then << "\n" << this->err();
}

INSTANTIATE_TEST_SUITE_P(Table, Trials, ::testing::ValuesIn(all_trials()),
                         [](const auto& row) { return row.param.id; });

}  // namespace
}  // namespace tribotrack::apps
