"""Results: dicts whose entries are attributes, which print in a few lines, show as a table in a notebook, and draw themselves.

Units stand in the names. matplotlib and pandas are imported by plot() and to_dataframe() alone.
"""

from __future__ import annotations

import html
import math
from importlib import import_module
from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class Result(dict[str, Any]):
    """What all results have in common."""

    if not TYPE_CHECKING:

        def __getattr__(self, name):
            try:
                return self[name]
            except KeyError:
                raise AttributeError(f"no `{name}` in this {type(self).__name__}: {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]

    def _heading(self) -> str:
        return f"{type(self).__name__} of {', '.join(self)}"

    def _rows(self) -> list[tuple[str, ...]]:
        """Those of a table, its head first."""
        return []

    def __repr__(self) -> str:
        rows = self._rows()
        widths = [max(map(len, column)) for column in zip(*rows)]
        lines = ("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)
        return "\n".join([self._heading(), *lines])

    def _repr_html_(self) -> str:
        lines = [
            "<tr>" + "".join(f"<{'td' if k else 'th'}>{html.escape(cell)}</{'td' if k else 'th'}>" for cell in row) + "</tr>"
            for k, row in enumerate(self._rows())
        ]
        heading = html.escape(self._heading()).replace("\n", "<br>")
        return f"<p>{heading}</p>" + (f"<table>{''.join(lines)}</table>" if lines else "")

    def _columns(self) -> dict[str, Any]:
        return {name: value for name, value in self.items() if hasattr(value, "shape")}

    def to_dataframe(self) -> Any:
        """A pandas DataFrame."""
        return import_module("pandas").DataFrame(self._columns())


class Simulation(Result):
    """Positions and velocities are relative to the platform, x right, y up."""

    time_s: Floats
    x_mm: Floats
    y_mm: Floats
    vx_mm_s: Floats
    vy_mm_s: Floats
    mu: Floats
    state: NDArray[np.str_]  # "slip" or "stick"
    end_x_mm: float
    end_y_mm: float
    alpha_rad: Optional[float]  # direction of the displacement, 0 .. 2 pi; None where there is none
    v_mm_s: float  # its length over the time
    cycles: float
    stops: int
    sticking_fraction: float
    steps: int
    steady: Optional[dict[str, Any]]  # alpha_rad, v_mm_s; None where no unique steady motion exists

    def _heading(self) -> str:
        alpha = "none" if self.alpha_rad is None else f"{self.alpha_rad:.6g} rad"
        return f"Simulation of {self.cycles:g} cycles: alpha {alpha}, v {self.v_mm_s:.6g} mm/s; {len(self.x_mm)} points"

    def plot(self, axes: Any = None) -> Any:
        """The path, x to the right and y up. Returns the axes."""
        return _path(self, ("x_mm", "y_mm"), axes)


class Track(Result):
    """One entry a frame; NaN where there is no value. Pixels: x right, y down; millimetres: y up."""

    frame: NDArray[np.int64]  # the recording's own number
    time_s: Floats
    x_px: Floats
    y_px: Floats
    sigma_x_px: Floats
    sigma_y_px: Floats
    rho_xy: Floats
    ncc: Floats
    status: NDArray[np.str_]  # "ok", "lost", "edge" or "repeat"
    x_mm: Floats
    y_mm: Floats
    sigma_x_mm: Floats
    sigma_y_mm: Floats
    theta_rad: Floats  # where the part's rotation is seen
    sigma_theta_rad: Floats
    marker_x_px: Floats  # where the platform's mark or texture is followed
    marker_y_px: Floats
    marker_sigma_px: Floats
    marker_ncc: Floats
    gate: Floats  # where a gate LED is given
    rho_xy_mm: Floats  # where part and mark lie in different planes
    marker_x_mm: Floats
    marker_y_mm: Floats
    marker_sigma_mm: Floats
    meta: dict[str, Any]  # what stands in T.csv.meta.json

    def _heading(self) -> str:
        words = list(self.status)
        counts = ", ".join(f"{words.count(word)} {word}" for word in ("ok", "lost", "edge", "repeat"))
        sigma = sorted(s for s in self.sigma_x_px if s == s)
        return f"Track of {len(words)} frames: {counts}" + (f"; median sd {sigma[len(sigma) // 2]:.2g} px" if sigma else "")

    def plot(self, axes: Any = None) -> Any:
        """The path, in millimetres where there is a scale. Returns the axes."""
        in_mm = "x_mm" in self and any(x == x for x in self.x_mm)
        axes = _path(self, ("x_mm", "y_mm") if in_mm else ("x_px", "y_px"), axes)
        if not in_mm:
            axes.invert_yaxis()
        return axes


class Sweep(Result):
    """The swept names with their values, and arrays of the grid's shape."""

    alpha_rad: Floats
    v_mm_s: Floats
    steady_alpha_rad: Floats
    steady_v_mm_s: Floats

    def _axes(self) -> list[str]:
        return list(self)[: self.v_mm_s.ndim]

    def _heading(self) -> str:
        return "Sweep over " + " and ".join(f"{name} ({len(self[name])} values)" for name in self._axes())

    def _columns(self) -> dict[str, Any]:
        import numpy as np

        grid = np.meshgrid(*(self[name] for name in self._axes()), indexing="ij")
        named = {name: values.ravel() for name, values in zip(self._axes(), grid)}
        return {**named, **{name: self[name].ravel() for name in list(self)[len(named) :]}}

    def plot(self) -> Any:
        """alpha and v against the first name, a line for each value of the second. Returns the figure."""
        plt = import_module("matplotlib.pyplot")
        figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
        first, *second = self._axes()
        for ax, name in zip(axes, ("alpha_rad", "v_mm_s")):
            lines = ax.plot(self[first], self[name], ".-")
            ax.set(xlabel=first, ylabel=name)
            if second and len(lines) <= 12:
                ax.legend(lines, [f"{value:.4g}" for value in self[second[0]]], title=second[0])
        return figure


class Measurement(Result):
    """Every quantity that a track shows; NAME_sd beside NAME."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    def _heading(self) -> str:
        return f"Measurement: {self.get('motion_sentence', '')}"

    def _rows(self) -> list[tuple[str, ...]]:
        measured = [(name, quoted(self[name], self[name + "_sd"])) for name in self if name + "_sd" in self]
        return [("quantity", "value(sd)"), *measured]

    def _columns(self) -> dict[str, Any]:
        names = [name for name in self if name + "_sd" in self]
        return {"quantity": names, "value": [self[n] for n in names], "sd": [self[n + "_sd"] for n in names]}


class Fit(Result):
    """What stands in fit.json."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    def _heading(self) -> str:
        words = {"use": "these values can be used", "care": "use with care", "do_not_use": "do not use these values"}
        lines = [f"Fit to {len(self.runs)} runs: {words.get(self.verdict, self.verdict)}; chi2 {_short(self.chi2)} at {self.dof} dof"]
        lines += [f"  - {reason}" for reason in self.verdict_reasons]
        if self.get("quoted_under"):
            lines.append(f"  values under: {self.quoted_under}")
        return "\n".join(lines)

    def _rows(self) -> list[tuple[str, ...]]:
        rows: list[tuple[str, ...]] = [("parameter", "value(sd)", "95 % interval")]
        for name, p in self.parameters.items():
            digits = _digits(p.sd)
            rows.append((name, quoted(p.estimate, p.sd), " to ".join("open" if end is None else f"{end:.{digits}f}" for end in p.ci95)))
        return rows

    def _columns(self) -> dict[str, Any]:
        rows = list(self.parameters.items())
        return {
            "parameter": [name for name, _ in rows],
            "estimate": [p.estimate for _, p in rows],
            "sd": [p.sd for _, p in rows],
            "ci95_low": [p.ci95[0] for _, p in rows],
            "ci95_high": [p.ci95[1] for _, p in rows],
        }

    def plot(self) -> Any:
        """alpha and v of the driven runs, measured and modelled, against phi, or dtau where that varies more. Returns the figure."""
        plt = import_module("matplotlib.pyplot")
        runs = [run for run in self.runs if run.get("phi_rad") is not None]
        over = max(("phi_rad", "dtau_rad"), key=lambda name: len({run[name] for run in runs}))
        figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
        for ax, name in zip(axes, ("alpha_rad", "v_mm_s")):
            seen = [(run[over], o) for run in runs for o in run.get("observables", []) if o["observable"] == name]
            x = [at for at, _ in seen]
            ax.errorbar(x, [o.measured for _, o in seen], [o.sd for _, o in seen], fmt="o", label="measured")
            ax.plot(x, [o.modelled for _, o in seen], "k+", ms=10, label="model")
            ax.set(xlabel=over, ylabel=name)
        axes[0].legend()
        return figure


def wrapped(value: Any) -> Any:
    """Dicts within dicts and lists have attributes as well."""
    if type(value) is dict:
        return Result({name: wrapped(entry) for name, entry in value.items()})
    return [wrapped(entry) for entry in value] if type(value) is list else value


def quoted(value: Optional[float], sd: Optional[float]) -> str:
    """0.10003(50): the standard deviation of the last digits."""
    if value is None or not sd:
        return _short(value)
    digits = _digits(sd)
    return f"{value:.{digits}f}({sd:.{digits}f})" if sd >= 1 else f"{value:.{digits}f}({round(sd * 10**digits)})"


def _digits(sd: Optional[float]) -> int:
    return max(0, 1 - math.floor(math.log10(float(f"{sd:.1e}")))) if sd else 6


def _short(value: Optional[float]) -> str:
    return "not determined" if value is None else f"{value:.4g}"


def _path(result: Result, names: tuple[str, str], axes: Any) -> Any:
    if axes is None:
        plt = import_module("matplotlib.pyplot")
        axes = plt.subplots()[1]
    axes.plot(result[names[0]], result[names[1]], lw=1)
    axes.set(xlabel=names[0], ylabel=names[1], aspect="equal")
    return axes
