#!/usr/bin/env python3
"""Draws the figures of a campaign for print from the runs.csv beside it, with matplotlib (Debian: python3-matplotlib).

    python3 figures.py [NAME ...]

alpha-phi, alpha-dtau, v-phi, v-dtau: measured with one standard deviation, and the fitted model at the same runs (line), one
colour for each value that the runs share; residuals: in standard deviations. NAME-84mm and NAME-174mm are one and two columns
wide, SVG (glyphs as outlines) and PDF (TrueType fonts embedded). The same runs.csv gives the same bytes; edit what you like.
"""
import csv
import math
import pathlib
import sys
from fractions import Fraction

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#8a5f00"]
SYMBOLS = ["o", "s", "D", "^", "X", "P", "*", "h"]
TURN = 2 * math.pi
PHI, DTAU = ("phi_rad", "φ"), ("dtau_rad", "Δτ")
ALPHA = ("alpha_rad", "alpha_rad_sd", "alpha_model_rad", "direction α, rad")
V = ("v_mm_s", "v_mm_s_sd", "v_model_mm_s", "mean velocity v, mm/s")
DEPENDENCES = {"alpha-phi": (PHI, DTAU, ALPHA), "alpha-dtau": (DTAU, PHI, ALPHA), "v-phi": (PHI, DTAU, V), "v-dtau": (DTAU, PHI, V)}
NAMES = [*DEPENDENCES, "residuals"]

matplotlib.rcdefaults()  # none of a user's own settings
plt.rcParams.update({
    "svg.fonttype": "path", "svg.hashsalt": "tribotrack", "pdf.fonttype": 42, "text.usetex": False, "axes.linewidth": 0.6,
    "xtick.direction": "in", "ytick.direction": "in", "xtick.top": True, "ytick.right": True, "legend.frameon": False,
    "lines.markersize": 3.2, "lines.linewidth": 0.9, "errorbar.capsize": 1.5,
})


def runs_of(folder):
    """The rows of runs.csv; what is no number there stays text or is NaN."""
    def value(text):
        try:
            return float(text)
        except ValueError:
            return text or math.nan
    with open(folder / "runs.csv", newline="", encoding="utf-8") as rows:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(rows)]


def pi_text(rad):
    share = Fraction(rad / math.pi).limit_denominator(36)
    if abs(float(share) * math.pi - rad) > 1e-3:
        return f"{rad:.3g}"
    top = "π" if abs(share.numerator) == 1 else f"{abs(share.numerator)}π"
    return "0" if share == 0 else ("−" if share < 0 else "") + top + ("" if share.denominator == 1 else f"/{share.denominator}")


def groups_of(runs, shared, along):
    """Runs that share one angle and differ in the other, in the order of that."""
    groups = {}
    for run in runs:
        if not math.isnan(run["v_mm_s"]):
            groups.setdefault(round(run[shared] % TURN, 6), []).append((run[along] % TURN if along == "phi_rad" else run[along], run))
    return {key: sorted(group, key=lambda pair: pair[0]) for key, group in sorted(groups.items())
            if len({round(x, 6) for x, _ in group}) > 1}


def dependence(axes, runs, name):
    (along, symbol), (shared, shared_symbol), (measured, sd, model, title) = DEPENDENCES[name]
    groups = groups_of(runs, shared, along)
    for k, (key, group) in enumerate(groups.items()):
        look = {"color": COLOURS[k % len(COLOURS)]}
        x, y = [x for x, _ in group], [run[model] for _, run in group]
        for i in range(len(y) - 1, 0, -1):
            if measured == "alpha_rad" and abs(y[i] - y[i - 1]) > math.pi:  # starts again at the other end
                x.insert(i, math.nan)
                y.insert(i, math.nan)
        axes.plot(x, y, "-", **look)
        axes.errorbar([x for x, _ in group], [run[measured] for _, run in group], [run[sd] for _, run in group], fmt="none",
                      elinewidth=0.6, **look)
        axes.plot([x for x, _ in group], [run[measured] for _, run in group], SYMBOLS[k % len(SYMBOLS)], markeredgewidth=0,
                  label=f"{shared_symbol} = {pi_text(key)}", **look)
    axes.set_xlabel(f"{'phase' if along == 'phi_rad' else 'width'} {symbol} of the pulse, rad")
    axes.set_ylabel(title)
    for axis, is_angle in ((axes.xaxis, True), (axes.yaxis, measured == "alpha_rad")):
        if is_angle:
            low, high = axis.get_view_interval()
            axis.set_major_locator(MultipleLocator(math.pi / 2 if high - low > math.pi else math.pi / 6))
            axis.set_major_formatter(FuncFormatter(lambda rad, _: pi_text(rad)))
    return len(groups)


def residuals(axes, runs, _):
    axes.axhspan(-2, 2, color="#ececec", linewidth=0)
    shown = 0
    for k, key in enumerate(("dx", "dy")):
        points = [(run["number"], run[f"{key}_residual_sd"]) for run in runs if not math.isnan(run[f"{key}_residual_sd"])]
        axes.plot(*zip(*points) if points else ([], []), SYMBOLS[k], color=COLOURS[k], markeredgewidth=0, label=key)
        shown += len(points)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("run")
    axes.set_ylabel("residual, standard deviations")
    return shown


def main():
    folder = pathlib.Path(__file__).resolve().parent
    runs = runs_of(folder)
    for name in sys.argv[1:] or NAMES:
        for width_mm, size in ((84, 7), (174, 8)):
            plt.rcParams["font.size"] = size
            figure, axes = plt.subplots(figsize=(width_mm / 25.4, width_mm / 25.4 * (0.75 if width_mm < 100 else 0.5)),
                                        layout="constrained")
            if (residuals if name == "residuals" else dependence)(axes, runs, name):
                if len(axes.get_legend_handles_labels()[0]) <= len(COLOURS):
                    axes.legend()
                figure.savefig(folder / f"{name}-{width_mm}mm.svg", metadata={"Date": None, "Title": name})
                figure.savefig(folder / f"{name}-{width_mm}mm.pdf", metadata={"CreationDate": None, "Title": name})
            plt.close(figure)


if __name__ == "__main__":
    main()
