#!/usr/bin/env python3
"""Wrong inputs and faults, tried as a user would: each trial of the tables beside this file says what is prepared, what is typed,
the exit code, and what the answer must name. Use: trials.py TRIBOTRACK [WORD...]; with WORDs only trials that hold one.

A trial is a line "EXIT_CODE TITLE -> REGULAR EXPRESSION", indented lines of shell that prepare, lines "$ ..." that are typed, and
lines that must succeed afterwards. The folder holds c.toml, its recordings in rec/ and a finished result in out/; new results go to
o/. $said is the file of what was printed. A trial whose preparation ends with `needs COMMAND` failing is left out."""
import concurrent.futures
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
TRIBOTRACK = Path(sys.argv[1]).resolve()
WORK = Path(tempfile.mkdtemp(prefix="tribotrack-trials-"))
SKIPPED = 77

PRELUDE = r"""
needs() { "$@" >/dev/null 2>&1 || exit 77; }
line() { sed -i "$1s|.*|$2|" c.toml; }              # line NUMBER TEXT: replaces a line of the campaign
add() { printf '%s\n' "$@" >>c.toml; }              # add LINE...: at its end
edit() { sed -i -E "$@"; }
fit() { tribotrack fit c.toml --tracks out/tracks -o f.json "$@"; }
run() { tribotrack run c.toml -o o "$@"; }
track() { tribotrack track rec/a.cine --disc-diameter-mm 6 -o t.csv "$@"; }
measure() { tribotrack measure a.csv "$@"; }
a_track() { cp out/tracks/a.csv . && cp out/tracks/a.csv.meta.json .; }
# as_nobody COMMAND...: without root's rights
as_nobody() { setpriv --reuid=65534 --clear-groups "$@"; }
# scope FILE: the trace of the first run; trace FILE PHI DTAU [W]: half a second of an oscilloscope, a sensor's pulses on CH1,
# bursts of 5890 Hz on CH2
scope() { line 17 "dtau_rad = \"pi/3\"\nscope = \"$1\""; }
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
"""

# Of libraries, of the standard library and of debuggers, which tell a user nothing.
LIBRARY_WORDS = ("json.exception", "Encountered invalid utf-8", "Error while parsing", "saw '", "basic_string", "std::", "what():",
                 "_M_range_check", "Invalid data found", "moov", "OpenCV(", "CLI::", "not in range", "FAILED", "terminate called",
                 "stoi", "please report")


class Trial:
    def __init__(self, header):
        code, title = header.split(" ", 1)
        self.code = int(code)
        self.title, _, self.named = title.partition(" -> ")
        self.prepared, self.typed, self.then = [], [], []

    def add(self, text):
        if text.startswith("$ "):
            self.typed.append(text[2:])
        else:
            (self.then if self.typed else self.prepared).append(text)


def trials_of(file):
    trials = []
    for text in file.read_text().splitlines():
        if text.startswith("    "):
            trials[-1].add(text[4:])
        elif text and not text.startswith("#"):
            trials.append(Trial(text))
    return trials


def shell(folder, script, said=None):
    """Exit code and what went to the two streams. `said`: the file of what the command under trial printed."""
    environment = os.environ | {"LC_ALL": "C.UTF-8", "TERM": "xterm", "PATH": f"{TRIBOTRACK.parent}:{os.environ['PATH']}",
                                "SRC": str(HERE.parents[2]), "said": str(said)}
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        code = subprocess.run(["timeout", "-k", "5", "120", "bash", "-c", PRELUDE + script], cwd=folder, env=environment,
                              stdin=subprocess.DEVNULL, stdout=out, stderr=err, check=False).returncode
        texts = []
        for stream in (out, err):
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
    return code, *texts


def prepared_folder():
    """c.toml, rec/ and out/, which trials share: what is large is linked, not copied."""
    folder = WORK / "prepared"
    folder.mkdir()
    shutil.copy(HERE / "c.toml", folder)
    code, out, err = shell(folder, f"tribotrack synth '{HERE}/scene.toml' -o rec -q && tribotrack run c.toml -o out -q")
    if code != 0:
        sys.exit("the campaign that trials begin with failed:\n" + out + err)
    return folder


def link_or_copy(source, target):
    if os.path.getsize(source) > 100_000:
        os.link(source, target)
    else:
        shutil.copy2(source, target)


def files_in(folder):
    """What a command must leave as it was: all but results in o/ and recordings in late/, which trials change themselves."""
    files = {}
    for path in folder.rglob("*"):
        name = str(path.relative_to(folder))
        if not name.startswith(("o/", "late/")) and not (path.is_dir() and not path.is_symlink()):
            status = path.lstat()
            files[name] = (status.st_ino, status.st_size, status.st_mtime_ns)
    return files


def complaints_of(trial, number):
    folder = WORK / str(number) / "trial"
    shutil.copytree(WORK / "prepared", folder, copy_function=link_or_copy)
    said = folder.parent / "said"
    code, out, err = shell(folder, "set -eu\n" + "\n".join(trial.prepared))
    if code != 0:
        return SKIPPED if code == SKIPPED else [f"cannot be prepared:\n{out}{err}"]
    before = files_in(folder)
    code, out, err = shell(folder, "\n".join(trial.typed))
    said.write_text(out + err)
    after = files_in(folder)

    wrong = []
    if code != trial.code:
        wrong.append("it hangs" if code == 124 else f"exit code {code}")
    if not re.search(trial.named, out + err, re.DOTALL):
        wrong.append(f"does not name {trial.named}")
    wrong += [f"a library's word: {word}" for word in LIBRARY_WORDS if word in out + err]
    refused = trial.code in (2, 3)
    if refused and (out or not err.rstrip("\n").split("\n")[-1].startswith("tribotrack: ")):
        wrong.append("a refusal ends with one sentence, and prints nothing else")
    wrong += [f"{name} was changed" for name in before if after.get(name) != before[name]]
    wrong += [f"{name} was left" for name in after if ".partial-" in name or (refused and name not in before)]
    if wrong:
        wrong.append(f"stdout: {out[:2000]}\nstderr: {err[:4000]}")
    elif trial.then:
        code, out, err = shell(folder, "set -e\n" + "\n".join(trial.then), said)
        if code != 0:
            wrong.append(f"afterwards:\n{out}{err}")
    return wrong


def tried(trial, number):
    try:
        return complaints_of(trial, number)
    finally:
        shutil.rmtree(WORK / str(number), ignore_errors=True)


def main():
    trials = [(file.stem, trial) for file in sorted((HERE / "tables").glob("*.txt")) for trial in trials_of(file)]
    if sys.argv[2:]:
        trials = [(table, t) for table, t in trials if any(w in "\n".join([table, t.title, *t.prepared, *t.typed]) for w in sys.argv[2:])]
    WORK.chmod(0o755)
    prepared_folder()
    shared = files_in(WORK / "prepared")
    skipped = failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for (table, trial), wrong in zip(trials, pool.map(lambda t: tried(t[1][1], t[0]), enumerate(trials))):
            if wrong == SKIPPED:
                skipped += 1
                print(f"left out: {table}: {trial.title}")
            elif wrong:
                failed += 1
                print("\n".join([f"WRONG: {table}: {trial.title}", *trial.prepared, *("$ " + t for t in trial.typed), *wrong]), "\n")
    if files_in(WORK / "prepared") != shared:
        failed += 1
        print("WRONG: a trial has changed what all share")
    print(f"{len(trials)} trials, {failed} wrong, {skipped} left out")
    return failed > 0 or not trials


if __name__ == "__main__":
    try:
        code = main()
    finally:
        subprocess.run(["rm", "-rf", str(WORK)], check=False)
    sys.exit(code)
