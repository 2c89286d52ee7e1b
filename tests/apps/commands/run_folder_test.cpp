// The folder of `run`: who may write there, what is removed, what stays.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>

#include <fstream>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class RunFolders : public ProgramTest {};

TEST_F(RunFolders, ASecondRunIsRefusedWhileOneIsWriting) {
  render_slide("a.cine");
  put(in_folder("c.toml"), slides_campaign({"a.cine"}));
  ASSERT_EQ(run("run c.toml -o out -q").exit_code, 0);
  EXPECT_FALSE(fs::exists(in_folder("out/.lock")));
  const std::string fit = content_of(in_folder("out/fit.json"));
  put(in_folder("out/.lock"), "process 4711 on bench7 (campaign other.toml)\n");
  const int lock = ::open(in_folder("out/.lock").c_str(), O_RDWR);
  ASSERT_EQ(::flock(lock, LOCK_EX | LOCK_NB), 0);
  expect_refused(run("run c.toml -o out -q"), 3, {"out", "4711", "bench7", "other.toml"});
  expect_refused(run("fit c.toml --tracks out/tracks -o out/fit.json -q"), 3, {"4711"});
  EXPECT_EQ(content_of(in_folder("out/fit.json")), fit);
  // Reading is allowed: every file is whole.
  const Outcome page = run("report out -o page.html");
  EXPECT_EQ(page.exit_code, 0);
  EXPECT_THAT(page.err, HasSubstr("4711"));
  ::close(lock);  // as the kernel does when the holder dies
  EXPECT_EQ(run("run c.toml -o out -q").exit_code, 0);
}

TEST_F(RunFolders, WaitsForTheHolderOfTheFolder) {
  render_slide("a.cine");
  put(in_folder("c.toml"), slides_campaign({"a.cine"}));
  fs::create_directories(in_folder("out"));
  put(in_folder("wait.sh"),
      "( exec 9>out/.lock; flock 9; echo >taken; sleep 1.5 ) &\n"
      "while ! [ -e taken ]; do sleep 0.01; done\n"
      "'" TRIBOTRACK_BINARY
      "' run c.toml -o out --wait -q & p=$!\n"
      "sleep 0.5; test -e out/fit.json && echo early\n"
      "wait $p; echo exit $?\n");
  const Outcome waited = run("--version >version; bash wait.sh");
  EXPECT_THAT(waited.out, HasSubstr("exit 0\n")) << waited.err;
  EXPECT_THAT(waited.out, Not(HasSubstr("early")));
}

TEST_F(RunFolders, ATrackThatIsNotWhatWasWrittenIsMadeAgainAndSaid) {
  render_slide("a.cine");
  render_slide("b.cine", {.velocity_x = "90"});
  put(in_folder("c.toml"), slides_campaign({"a.cine", "b.cine"}));
  ASSERT_EQ(run("run c.toml -o out -q").exit_code, 0);
  const fs::path a = in_folder("out/tracks/a.csv"), meta = in_folder("out/tracks/a.csv.meta.json");
  const std::string table = content_of(a), described = content_of(meta),
                    other = content_of(in_folder("out/tracks/b.csv"));
  std::string edited = table, revision = described;
  edited[edited.size() / 2] = edited[edited.size() / 2] == '1' ? '2' : '1';
  revision.replace(revision.find("\"revision\": \"") + 13, 4, "0000");
  const auto expect_again = [&](const std::string& now, const std::string& its_meta, const std::string& why) {
    SCOPED_TRACE(why);
    put(a, now);
    put(meta, its_meta);
    expect_refused(run("verify out"), 3, {now == table ? "a.csv.meta.json (changed)" : "a.csv (changed)"});
    const Outcome again = run("run c.toml -o out");
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_THAT(again.err, HasSubstr("1 of 2 tracks were current"));
    EXPECT_THAT(again.err, HasSubstr("a was tracked again: " + why));
    EXPECT_EQ(content_of(a), table);
    EXPECT_EQ(content_of(meta), described);
    const Outcome verified = run("verify out");
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
  };
  const std::string changed = "its table was changed after it was written";
  expect_again(edited, described, changed);
  expect_again(table.substr(0, table.size() / 2), described, changed);
  expect_again("", described, changed);
  expect_again(other, described, changed);
  expect_again(table, revision, "another revision of this program had made it");
  expect_again(table, described.substr(0, 100), "its meta file was damaged");
}

TEST_F(RunFolders, VerifyNamesWhatIsNotOfTheRun) {
  render_slide("a.cine");
  fs::create_directory(in_folder("lab"));
  fs::rename(in_folder("a.cine"), in_folder("lab/a.cine"));
  put(in_folder("lab/c.toml"), slides_campaign({"a.cine"}));
  ASSERT_EQ(run("run lab/c.toml -o lab/out -q").exit_code, 0);
  EXPECT_THAT(run("verify lab/out").out, HasSubstr("files are those of its run"));
  fs::rename(in_folder("lab"), in_folder("moved"));  // with its recordings
  EXPECT_EQ(run("verify moved/out").exit_code, 0);
  std::ofstream(in_folder("moved/a.cine"), std::ios::app) << "more";
  std::ofstream(in_folder("moved/out/report.html"), std::ios::app) << "more";
  fs::remove(in_folder("moved/out/fit.json"));
  expect_refused(run("verify moved/out"), 3,
                 {"3 of 12", "moved/a.cine (changed)", "report.html (changed)", "fit.json (gone)"});
  expect_refused(run("verify moved"), 3, {"3 of 12"});
  fs::remove(in_folder("moved/out/run.json"));
  expect_refused(run("verify moved/out"), 3, {"run.json"});
}

}  // namespace
}  // namespace tribotrack::apps
