#!/usr/bin/env python3
"""Draws the figures of this folder for print, with matplotlib (Debian: python3-matplotlib).

    python3 figures.py [NAME ...]

Each figure is NAME.csv, its numbers, and NAME.json, how they are shown; both may be edited. Written are NAME-84mm and
NAME-174mm, one and two columns wide, as SVG (glyphs as outlines) and PDF (TrueType fonts embedded). The same input gives the
same bytes.
"""
import copy
import csv
import json
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib import cm, colors
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#8a5f00"]
SYMBOLS = ["o", "s", "D", "^", "X", "P", "*", "h"]
INK, GREY, STRIPE = "#1a1a1a", "#666666", "#ececec"
MM = 1 / 25.4
WIDTHS = (84, 174)

plt.rcParams.update({
    "svg.fonttype": "path", "svg.hashsalt": "tribotrack", "pdf.fonttype": 42, "font.family": "DejaVu Sans",
    "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.direction": "in",
    "ytick.direction": "in", "xtick.top": True, "ytick.right": True, "legend.frameon": False, "legend.handlelength": 1.6,
    "axes.formatter.useoffset": False, "axes.formatter.limits": (-4, 5), "axes.formatter.use_mathtext": True, "axes.unicode_minus": True,
})


def number(text):
    return float(text) if text else math.nan


def read(folder, name):
    """The figure with the numbers of its CSV in its series."""
    figure = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    for panel in figure["panels"]:
        for series in panel["series"]:
            series.update({"x": [], "y": [], "sd": [], "y_high": [], "notes": []})
    with open(folder / f"{name}.csv", newline="", encoding="utf-8") as rows:
        for row in csv.DictReader(rows):
            series = figure["panels"][int(row["panel"]) - 1]["series"][int(row["series"]) - 1]
            for key in ("x", "y", "sd", "y_high"):
                series[key].append(number(row[key]))
            series["notes"].append(row["note"])
    return figure


def colour_of(series, scale):
    if "value" in series:
        return scale.to_rgba(series["value"])
    return {-1: INK, -2: GREY}.get(series["colour"]) or COLOURS[series["colour"] % len(COLOURS)]


def draw_series(axes, series, scale, size):
    colour, mark = colour_of(series, scale), series["mark"]
    thin = "value" in series or series.get("small")
    x, y = series["x"], series["y"]
    if mark == "line":
        axes.plot(x, y, color=colour, linewidth=0.6 if thin else 1.0, linestyle="--" if series.get("dashed") else "-",
                  zorder=2)
    elif mark == "band":
        axes.fill_between(x, y, series["y_high"], color=colour, alpha=0.22, linewidth=0, zorder=1)
    elif mark == "bars":
        axes.barh(y, x, height=0.62, color=colour, zorder=2)
    elif mark == "text":
        for px, py, note in zip(x, y, series["notes"]):
            axes.annotate(note, (px, py), color=colour, fontsize=size, fontweight="bold", ha="center", va="center", zorder=4)
    else:
        symbol = SYMBOLS[series["colour"] % len(SYMBOLS)] if series.get("colour", -1) >= 0 else "o"
        axes.plot(x, y, linestyle="none", marker=symbol, color=colour, zorder=3,
                  markersize=1.0 if series.get("small") else 2.2 if thin else 4.6 if series.get("large") else 3.2, markeredgewidth=0)
        if not all(math.isnan(sd) for sd in series["sd"]):
            bars = [0 if math.isnan(sd) else sd for sd in series["sd"]]
            axes.errorbar(x, y, yerr=bars, linestyle="none", ecolor=colour, elinewidth=0.6,
                          capsize=0 if series.get("small") else 1.5, zorder=3)


def ticks_that_fit(axis, inches, size):
    """Every second label, or fewer, where all of them would run into each other."""
    wide = max(len(label) for label in axis["labels"]) * size * 0.75 / 72 + 0.06
    step = max(1, math.ceil(len(axis["ticks"]) * wide / max(inches, 0.1)))
    return axis["ticks"][::step], axis["labels"][::step]


def draw_axis(axes, axis, along, size, inches):
    is_x = along == "x"
    if axis.get("log"):
        (axes.set_xscale if is_x else axes.set_yscale)("log")
    (axes.set_xlim if is_x else axes.set_ylim)(axis["low"], axis["high"])
    if axis.get("ticks"):
        ticks, labels = ticks_that_fit(axis, inches, size) if is_x else (axis["ticks"], axis["labels"])
        (axes.set_xticks if is_x else axes.set_yticks)(ticks, labels)
    elif not axis.get("log"):
        axes.locator_params(axis=along, nbins=max(3, min(7, int(inches / 0.42))))
    axes.tick_params(axis=along, labelsize=size, length=2.5)
    if axis.get("hidden"):
        axes.tick_params(axis=along, **({"labelbottom": False} if is_x else {"labelleft": False}))
    else:
        (axes.set_xlabel if is_x else axes.set_ylabel)(axis["title"], fontsize=size, labelpad=2)


def legend_entries(figure, scale):
    entries = {}
    for panel in figure["panels"]:
        for series in panel["series"]:
            if not series.get("in_legend") or series["name"] in entries:
                continue
            colour = colour_of(series, scale)
            if series["mark"] in ("band", "bars"):
                entries[series["name"]] = Patch(color=colour, alpha=0.5, linewidth=0)
            elif series["mark"] == "line":
                entries[series["name"]] = Line2D([], [], color=colour, linestyle="--" if series.get("dashed") else "-")
            else:
                symbol = SYMBOLS[series["colour"] % len(SYMBOLS)] if series.get("colour", -1) >= 0 else "o"
                entries[series["name"]] = Line2D([], [], color=colour, linestyle="none", marker=symbol, markersize=3.5)
    return entries


def stacked(figure):
    """Panels that stand side by side, one below the other: for a narrow column."""
    figure = copy.deepcopy(figure)
    figure["height"] *= 0.8 * figure["columns"]
    figure["columns"] = 1
    for panel in figure["panels"]:
        panel["y"].pop("hidden", None)
    return figure


def draw(figure, width_mm):
    if width_mm < 120 and figure["columns"] > 1 and not figure["shared_x"] and all(p["series"] for p in figure["panels"]):
        figure = stacked(figure)
    size = 7 if width_mm < 120 else 8
    columns = figure["columns"]
    rows = math.ceil(len(figure["panels"]) / columns)
    heights = [max(p.get("height", 1) for p in figure["panels"][r * columns:(r + 1) * columns]) for r in range(rows)]
    narrow = 1.2 if width_mm < 120 else 0.85
    width = width_mm * MM
    paper = plt.figure(figsize=(width, width * figure["height"] * narrow), layout="constrained")
    grid = paper.add_gridspec(rows, columns, height_ratios=heights)
    scale = None
    if "colours" in figure:
        scale = cm.ScalarMappable(colors.Normalize(figure["colours"]["low"], figure["colours"]["high"]), "cividis")
    drawn, first = [], {}
    for i, panel in enumerate(figure["panels"]):
        if not panel["series"]:
            continue
        axes = paper.add_subplot(grid[i // columns, i % columns],
                                 sharex=first.get(i % columns) if figure["shared_x"] else None)
        first.setdefault(i % columns, axes)
        for low, high in panel.get("stripes", []):
            axes.axhspan(low, high, color=STRIPE, linewidth=0, zorder=0)
        for low, high in panel.get("spans", []):
            axes.axvspan(low, high, color=COLOURS[1], alpha=0.18, linewidth=0, zorder=0)
        if panel.get("zero_line"):
            axes.axhline(0, color=GREY, linewidth=0.5, zorder=1)
        for series in panel["series"]:
            draw_series(axes, series, scale, size)
        draw_axis(axes, panel["x"], "x", size, width / columns - 0.5)
        draw_axis(axes, panel["y"], "y", size, width * figure["height"] * narrow * heights[i // columns] / sum(heights) - 0.3)
        if panel.get("equal_scale"):
            axes.set_aspect("equal", adjustable="datalim" if not figure["shared_x"] else "box")
        if panel.get("title"):
            axes.set_title(panel["title"], fontsize=size, loc="left", pad=3)
        drawn.append(axes)
    if scale is not None:
        bar = paper.colorbar(scale, ax=drawn, orientation="horizontal", fraction=0.05, aspect=40, pad=0.02)
        bar.set_label(figure["colours"]["title"], fontsize=size)
        bar.ax.tick_params(labelsize=size)
        if figure["colours"].get("ticks"):
            bar.set_ticks(figure["colours"]["ticks"], labels=figure["colours"]["labels"])
    entries = legend_entries(figure, scale)
    if entries:
        longest = max(len(name) for name in entries)
        per_row = max(1, min(len(entries), int(width * 72 / (size * (0.58 * longest + 3.5)))))
        paper.legend(entries.values(), entries.keys(), loc="lower center", ncols=per_row, fontsize=size,
                     columnspacing=1.2, handletextpad=0.5, borderaxespad=0.2)
        room = (math.ceil(len(entries) / per_row) * 1.35 + 0.7) * size / 72 / paper.get_figheight()
        paper.get_layout_engine().set(rect=(0, room, 1, 1 - room))
    return paper


def main():
    folder = pathlib.Path(__file__).resolve().parent
    names = sys.argv[1:] or sorted(path.stem for path in folder.glob("*.json") if path.with_suffix(".csv").exists())
    for name in names:
        figure = read(folder, name)
        for width in WIDTHS:
            paper = draw(figure, width)
            stem = folder / f"{name}-{width}mm"
            paper.savefig(f"{stem}.svg", metadata={"Date": None, "Title": figure["title"]})
            paper.savefig(f"{stem}.pdf", metadata={"CreationDate": None, "Title": figure["title"]})
            plt.close(paper)


if __name__ == "__main__":
    main()
