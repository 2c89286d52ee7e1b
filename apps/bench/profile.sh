#!/usr/bin/env bash
# Where the time of each command goes, for the next person who makes one faster: samples it with perf every 2 ms of CPU
# time and writes, into OUT_DIR, COMMAND.txt (hottest functions by their own time, and together with what they call; of
# `track` also the time of each stage) and COMMAND.svg (flame graph: width is time, callers below).
# Use: apps/bench/profile.sh BINARY OUT_DIR [COMMAND...]
# COMMAND: simulate sweep track_plain track_layered track_h264 run fit report (default: all of them, some minutes). Inputs are
# rendered into OUT_DIR/inputs, and taken from there where they are; 2 GB of disk are needed for all.
set -euo pipefail
usage="Use: $0 BINARY OUT_DIR [COMMAND...]"
binary=$(realpath "${1:?$usage}")
mkdir -p "${2:?$usage}"
out=$(cd "$2" && pwd)
shift 2
cd "$(dirname "$0")/../.."
if ! command -v perf >/dev/null; then
  echo "$0: there is no perf; install the Debian package linux-perf" >&2
  exit 3
fi
inputs=$out/inputs
mkdir -p "$inputs"

# The example's scene without its shots, 640 x 400, 300 frames, with these edits (sed).
recording() {  # NAME.EXTENSION EDIT...
  [ -f "$inputs/$1" ] && return
  local name=$1 edits=(-e '/^\[\[shot/,$d' -e 's/^width.*/width = 640/' -e 's/^height.*/height = 400/' -e 's/^cycles.*/cycles = 12/'
    -e 's/^lag_rad.*/&\nphi_rad = 0\ndtau_rad = 1/')
  shift
  sed "${edits[@]}" "$@" data/example/scene.toml >"$inputs/${name%.*}.toml"
  "$binary" synth "$inputs/${name%.*}.toml" -o "$inputs/$name" -q
}

campaign() {
  cp data/example/campaign.toml "$inputs"
  [ -d "$inputs/recordings" ] || "$binary" synth data/example/scene.toml -o "$inputs/recordings" -q
}

result() {
  campaign
  [ -f "$inputs/result/fit.json" ] || "$binary" run "$inputs/campaign.toml" -o "$inputs/result" -q >/dev/null
}

# Samples of `perf script` as lines "caller;called;...;innermost": one a sample.
fold() {
  awk '
    function close_sample() { if (stack != "") print stack; stack = "" }
    /^[^\t ]/ || /^$/ { close_sample(); next }
    {
      sub(/^[\t ]+[0-9a-f]+ /, "")
      gsub(/tribotrack::|\(anonymous namespace\)::|;/, "")
      gsub(/, std::allocator<[^<>]*> ?/, "")
      if (/^CLI::|^std::_Function_handler|^__libc_start/) next
      stack = stack == "" ? $0 : $0 ";" stack
    }
    END { close_sample() }'
}

hottest() {
  awk -F';' '
    { ++self[$NF]; ++samples; delete seen; for (k = 1; k <= NF; ++k) if (!seen[$k]++) ++whole[$k] }
    function table(title, count,   name, sorted) {
      printf "\n%7s  %s\n", "share", title
      sorted = "sort -k1,1nr -k2 | head -40"
      for (name in count) printf "%6.2f %%  %s\n", 100 * count[name] / samples, name | sorted
      close(sorted)
    }
    END {
      printf "%d samples of 2 ms\n", samples
      fflush()
      table("function: its own time", self)
      table("function: with all that it calls", whole)
    }'
}

# Stacks that begin alike lie beside each other once sorted: a box for each run of equal callers.
flame_graph() {
  LC_ALL=C sort | awk -F';' -v title="$1" '
    function shown(text) { gsub(/&/, "\\&amp;", text); gsub(/</, "\\&lt;", text); gsub(/>/, "\\&gt;", text); return text }
    function close_from(depth,   d) {
      for (d = open; d >= depth; --d) { ++boxes; level[boxes] = d; from[boxes] = begin[d]; to[boxes] = x; name[boxes] = frame[d] }
      open = depth - 1
    }
    {
      for (same = 0; same < open && same < NF && frame[same + 1] == $(same + 1); ++same) {}
      close_from(same + 1)
      for (d = same + 1; d <= NF; ++d) { frame[d] = $d; begin[d] = x }
      open = NF
      if (NF > deepest) deepest = NF
      ++x
    }
    END {
      close_from(1)
      width = 1600; row = 17; height = (deepest + 2) * row
      printf "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"monospace\" font-size=\"11\">\n", width, height
      printf "<text x=\"4\" y=\"12\">%s: %d samples of 2 ms of CPU time</text>\n", shown(title), x
      for (b = 1; b <= boxes; ++b) {
        w = width * (to[b] - from[b]) / x
        if (w < 0.5) continue
        left = width * from[b] / x
        y = height - level[b] * row
        printf "<g><title>%s, %.2f %%</title>", shown(name[b]), 100 * (to[b] - from[b]) / x
        printf "<rect x=\"%.1f\" y=\"%d\" width=\"%.1f\" height=\"%d\" fill=\"hsl(%d,75%%,72%%)\" stroke=\"#fff\" stroke-width=\"0.5\"/>", \
          left, y, w, row - 1, 10 + length(name[b]) * 7 % 45
        if (w > 40) printf "<text x=\"%.1f\" y=\"%d\">%s</text>", left + 2, y + 12, shown(substr(name[b], 1, int(w / 6.7)))
        print "</g>"
      }
      print "</svg>"
    }'
}

profile() {  # NAME ARGUMENT...
  local name=$1 data=$out/$1.perf said=$out/$1.said
  shift
  echo "$name: tribotrack $*"
  if ! perf record -q -e cpu-clock -F 500 --call-graph dwarf,65528 -o "$data" "$binary" "$@" >/dev/null 2>"$said"; then
    cat "$said" >&2
    echo "$0: perf could not record \`tribotrack $*\`; the lines above say why" >&2
    exit 3
  fi
  perf script -i "$data" --no-inline -F comm,ip,sym 2>/dev/null | fold >"$out/$name.folded"
  {
    echo "tribotrack $*"
    hottest <"$out/$name.folded"
    sed -n '/^time of each stage/,/^[^ t]/{/^[t ]/p}' "$said"
  } >"$out/$name.txt"
  flame_graph "tribotrack $*" <"$out/$name.folded" >"$out/$name.svg"
  rm "$data" "$said" "$out/$name.folded"
}

track=(--marker "40,40,14" --explain)
for name in "${@:-simulate sweep track_plain track_layered track_h264 run fit report}"; do
  for command in $name; do
    case $command in
      simulate)
        profile simulate simulate --mu1 0.1 --mu2 0.0125 --amplitude-mm 0.28 --omega-rad-s 62.8 --phi-rad pi/2 --dtau-rad pi/3 \
          --cycles 20 -o "$out/simulate.csv"
        ;;
      sweep) profile sweep sweep data/figure7a.toml -o "$out/sweep.csv" ;;
      track_plain)
        recording plain.cine -e 's/^texture_rms.*/texture_rms = 0/'
        profile track_plain track "$inputs/plain.cine" -o "$out/track.csv" "${track[@]}"
        ;;
      track_layered)
        recording layered.cine
        profile track_layered track "$inputs/layered.cine" -o "$out/track.csv" "${track[@]}"
        ;;
      track_h264)
        recording layered.mp4
        profile track_h264 track "$inputs/layered.mp4" -o "$out/track.csv" "${track[@]}" --fps 250 --fps-reason rendered
        ;;
      run)
        campaign
        rm -rf "$inputs/result"
        profile run run "$inputs/campaign.toml" -o "$inputs/result"
        ;;
      fit)
        result
        profile fit fit "$inputs/campaign.toml" --tracks "$inputs/result/tracks" -o "$out/fit.json"
        ;;
      report)
        result
        profile report report "$inputs/result" -o "$out/report.html"
        ;;
      *)
        echo "$0: there is no profile of \"$command\"; $usage" >&2
        exit 2
        ;;
    esac
  done
done
rm -f "$out"/{simulate,sweep,track}.csv* "$out"/fit.json* "$out"/report.html*
