"""From high-speed video of a part on a vibrating platform to its friction parameters.

The functions are the commands of the program `tribotrack` of the same name: keywords are its flags, results its
files, as dicts of NumPy arrays and numbers whose names hold the units and are attributes, too. They print in a few lines,
plot() draws them, to_dataframe() makes a pandas table of them. Angles are radians, or texts such as "pi/3" and "90deg". Long
work leaves other Python threads running and ends on Ctrl-C.

    import tribotrack
    run = tribotrack.simulate(mu1=0.1, phi_rad="pi/2", cycles=20)
    print(run.alpha_rad, run.v_mm_s)
    track = tribotrack.track("phi000.cine", disc_diameter_mm=6, marker="auto")
    print(tribotrack.measure(track).alpha_rad)
    print(tribotrack.fit("campaign.toml"))
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tribotrack import _calling
from tribotrack._core import __version__
from tribotrack._errors import AmbiguousPartError, InputError, MissingFileError, QualityWarning
from tribotrack._results import Fit, Measurement, Simulation, Sweep, Track, wrapped

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping
    from typing import Any, Optional, Union

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Angle = Union[float, str]
    Path = Union[str, os.PathLike[str]]
    Circle = tuple[float, float, float]
    Progress = Callable[[str, int, int], object]

__all__ = [
    "AmbiguousPartError",
    "Fit",
    "InputError",
    "Measurement",
    "MissingFileError",
    "QualityWarning",
    "Simulation",
    "Sweep",
    "Track",
    "__version__",
    "fit",
    "measure",
    "simulate",
    "sweep",
    "track",
]


def simulate(
    scenario: Optional[Path] = None,
    *,
    mu1: Optional[float] = None,
    mu2: Optional[float] = None,
    mu1_over_mu2: Optional[float] = None,
    amplitude_mm: Optional[float] = None,
    amplitude_y_mm: Optional[float] = None,
    omega_rad_s: Optional[float] = None,
    epsilon_rad: Optional[Angle] = None,
    phi_rad: Optional[Angle] = None,
    dtau_rad: Optional[Angle] = None,
    lag_rad: Optional[Angle] = None,
    gravity_m_s2: Optional[float] = None,
    tilt_x_rad: Optional[Angle] = None,
    tilt_y_rad: Optional[Angle] = None,
    cycles: Optional[float] = None,
    start: Optional[str] = None,
    start_phase_rad: Optional[Angle] = None,
    velocity_x_mm_s: Optional[float] = None,
    velocity_y_mm_s: Optional[float] = None,
    spin_rad_s: Optional[float] = None,
    radius_mm: Optional[float] = None,
    spin_inertia: Optional[float] = None,
    samples_per_cycle: Optional[int] = None,
) -> Simulation:
    """One trajectory of the friction model, as `tribotrack simulate`.

    What is not given is the scenario file's or, without one, the source paper's: mu1 = 0.1, mu2 = 0.0125, a circle of
    amplitude_mm = 0.28 at omega_rad_s = 62.8 (epsilon_rad = pi/2, clockwise), no pulse (dtau_rad = 0),
    gravity_m_s2 = 9.81, cycles = 20, from rest.

    Args:
        scenario: a scenario file (TOML), whose values the keywords override.
        mu1, mu2: friction outside and inside the pulse; or mu1_over_mu2 in place of mu2.
        amplitude_mm, amplitude_y_mm: of the platform; the second where it differs.
        phi_rad, dtau_rad, lag_rad: the pulse opens at phi + lag and is dtau wide.
        tilt_x_rad, tilt_y_rad: of the platform, towards +x and +y.
        start: "rest", "circling" or "steady". start_phase_rad: the platform's phase there.
        velocity_x_mm_s, velocity_y_mm_s: at the start, relative to the platform.
        spin_rad_s, radius_mm, spin_inertia: of a disc that slides freely and turns.
        samples_per_cycle: rows of the arrays, 100 where not given.

    Returns:
        The arrays time_s, x_mm, y_mm, vx_mm_s, vy_mm_s, mu, state ("slip", "stick"), and end_x_mm, end_y_mm,
        alpha_rad, v_mm_s, cycles, stops, sticking_fraction, steps, steady.

    Raises:
        InputError: a value out of its range; MissingFileError: no such scenario.
    """
    values = {name: value for name, value in locals().items() if name != "scenario"}
    return Simulation(_calling.call("simulate", scenario, values))


def sweep(
    scenario: Optional[Path] = None,
    *,
    over: Optional[Mapping[str, ArrayLike]] = None,
    start: Optional[str] = None,
    threads: Optional[int] = None,
    progress: Optional[Progress] = None,
    **conditions: Angle,
) -> Sweep:
    """alpha and v of the model over one or two parameters, as `tribotrack sweep`, on all cores.

    Args:
        scenario: a scenario file (TOML); without one the paper's conditions.
        over: names of one or two of simulate()'s quantities with their values, the first along the first axis;
            without it what the scenario's [sweep] says.
        start: "rest", "circling" or "steady". threads: at work; all where not given.
        progress: called as progress(stage, done, total).
        conditions: other quantities of simulate() by name.

    Returns:
        The swept names with their values, and alpha_rad, v_mm_s, steady_alpha_rad, steady_v_mm_s, arrays of the
        grid's shape; NaN where there is none.
    """
    if over is not None and not isinstance(over, dict):
        raise InputError("over must be a dict of one or two names with their values")
    options: dict[str, Any] = {**conditions, "start": start, "over": over, "threads": threads}
    result = _calling.call("sweep", scenario, options, progress)
    axes = list(result)[:-4]
    shape = [len(result[name]) for name in axes]
    return Sweep({name: values if name in axes else values.reshape(shape) for name, values in result.items()})


def track(
    source: Union[Path, NDArray[np.uint8], NDArray[np.uint16]],
    *,
    fps: Optional[float] = None,
    fps_reason: Optional[str] = None,
    mm_per_px: Optional[float] = None,
    disc_diameter_mm: Optional[float] = None,
    chamfer_mm: Optional[float] = None,
    calibration: Optional[Path] = None,
    tag_mm: Optional[float] = None,
    height_mm: Optional[float] = None,
    working_distance_mm: Optional[float] = None,
    disc: Optional[Circle] = None,
    template: Optional[tuple[int, int, int, int]] = None,
    marker: Union[Circle, str, None] = None,
    gate: Optional[Circle] = None,
    frames: Union[
        tuple[Optional[int], Optional[int]], tuple[Optional[int], Optional[int], Optional[int]], None
    ] = None,
    xi_axis_rad: Optional[Angle] = None,
    layers: Optional[str] = None,
    config: Optional[Path] = None,
    bits: Optional[int] = None,
    output: Optional[Path] = None,
    overlay: Optional[Path] = None,
    threads: Optional[int] = None,
    progress: Optional[Progress] = None,
) -> Track:
    """The part in every frame of a recording, to a fraction of a pixel, as `tribotrack track`.

    Args:
        source: a .cine, a .mraw, a video, a TIFF, a folder of pictures or a pattern "dir/%05d.png"; or an array of grey
            levels (frames, height, width), uint8 or uint16, which is read where it lies (any strides, read-only too)
            and must not change meanwhile.
        fps: frames per second; an array always needs it. fps_reason: how you know.
        mm_per_px, disc_diameter_mm, calibration, tag_mm (side of the tag that is the marker): the scale, by one of
            them; without it positions are in pixels only. A diameter beside another scale checks that.
        chamfer_mm: width of the disc's chamfer seen from above, 0 for a sharp edge.
        height_mm, working_distance_mm: of the part's top and the lens above the platform, for the parallax.
        disc: (x, y, radius) of the part in the first frame, px; template: (x, y, width, height) in its place.
        marker: (x, y, radius) of a mark on the platform, "auto", "texture", "none" or a tag, "tag:apriltag_36h11:3".
        gate: (x, y, radius) of a lamp that is lit while the actuator is on.
        frames: (first, last) by the recording's own numbers, both included; (first, last, n) for every n-th of
            them; each may be None.
        xi_axis_rad: direction of the platform's displacement at phase 0 in the picture.
        layers: second pass: "auto", "on" or "off".
        config: a TOML file with [camera], [part], [track].
        bits: significant bits of an array's levels, where they are fewer than its type holds.
        output, overlay: files to write as well: T.csv with its meta file, a picture or video.
        threads: at work; all where not given. progress: called as progress("track", done, total).

    Returns:
        The columns of T.csv as arrays, `status` ("ok", "lost", "edge", "repeat") among them, and `meta`, what stands in
        its meta file.

    Raises:
        InputError, MissingFileError; AmbiguousPartError: several discs may be the part.

    Warns:
        QualityWarning: the part was lost too often, or is no moving part.
    """
    options = {name: value for name, value in locals().items() if name not in ("source", "bits", "progress")}
    if _calling.is_path(source):
        return Track(_calling.call("track", source, options, progress, bits=bits))
    return Track(_calling.call("track", "frames in memory", options, progress, source, bits))


def measure(
    track: Union[Path, Track, Mapping[str, Any]],
    *,
    omega_rad_s: Optional[float] = None,
    epsilon_rad: Optional[Angle] = None,
    cycles: Optional[int] = None,
    free_slide: bool = False,
    gravity_m_s2: Optional[float] = None,
    mm_per_px: Optional[float] = None,
    fps: Optional[float] = None,
    track_unit: Optional[str] = None,
    track_y: Optional[str] = None,
    track_frame: Optional[str] = None,
    track_point: Optional[str] = None,
    track_mark: Optional[str] = None,
) -> Measurement:
    """alpha, v and what else one track shows, as `tribotrack measure --json`.

    Args:
        track: what track() returned, a table with its columns (pandas), or the path of a T.csv.
        omega_rad_s: angular frequency of the platform, where no mark shows it.
        epsilon_rad: phase shift that the platform should have: its sense is checked.
        cycles: whole cycles to measure over, at most; 20 where not given.
        free_slide: the platform rests and the part slides. gravity_m_s2: of such a slide, 9.81 where not given.
        mm_per_px, fps, track_unit ("px", "um", "mm", "cm", "m"), track_y ("up", "down"), track_frame ("platform",
            "camera"), track_point, track_mark: what the file of another program (Tracker, Kinovea, DLTdv, trackpy, ...) does not say of itself; track is then its path.

    Returns:
        Every quantity that can be told, dx_mm, dy_mm, alpha_rad, v_mm_s, amplitude_mm, ..., with its standard deviation
        under the same name and _sd.
    """
    options = {name: value for name, value in locals().items() if name != "track"}
    if _calling.is_path(track):
        return Measurement(wrapped(_calling.call("measure", track, options)))
    if not hasattr(track, "keys"):
        raise InputError(f"the track must be a path or a dict of columns, not {type(track).__name__}")
    table: Any = track
    given = {"csv": _calling.csv_of(table), "meta": table["meta"] if "meta" in table else None}
    return Measurement(wrapped(_calling.call("measure", "track", options, given=given)))


def fit(
    campaign: Union[Path, Mapping[str, Any]],
    *,
    part: Optional[str] = None,
    tracks: Optional[Path] = None,
    allow_missing: int = 0,
    loss: str = "squares",
    bootstrap: int = 0,
    seed: int = 1,
    compare_models: bool = False,
    threads: Optional[int] = None,
    progress: Optional[Progress] = None,
    **conditions: Any,
) -> Fit:
    """mu1, mu2 and the actuator's phase lag with their uncertainty, as `tribotrack fit`.

    Args:
        campaign: the path of a campaign file; a dict of its structure, paths in it relative to the working folder; or a
            table of displacements: a pandas DataFrame, a dict of arrays, or the path of a .csv, .tsv, .txt or .dat, with
            columns as the command line reads them: phi_rad or "phi (deg)", dtau, alpha, v, their sd, and any other key of [[run]].
        part: which of the campaign's several [[part]].
        tracks: folder with the runs' tracks, NAME.csv; without it videos are tracked now.
        allow_missing: go on where up to so many runs are not usable.
        loss: "squares" or "huber". bootstrap: refits to simulated data, seed: of their noise.
        compare_models: compare tilt and other laws of friction in any case.
        threads: at work; all where not given. progress: called as progress(stage, done, total).
        conditions: of a table: amplitude_mm, amplitude_y_mm, angular_frequency_rad_s, phase_shift_rad, gravity_m_s2,
            tilt_x_rad, tilt_y_rad, each also with _sd; parameters, start, cycles, fixed, guess, prior, exact as in [fit];
            alpha_sd_rad, v_sd_mm_s of lines that have none.

    Returns:
        What stands in fit.json: parameters.mu1.estimate, .sd, .ci95, correlation, chi2, dof, converged, identifiability,
        runs, budget, warnings, next_experiment, ...

    Raises:
        InputError, MissingFileError.

    Warns:
        QualityWarning: the fit should not be used as it is.
    """
    from tribotrack import _tables

    options = {
        "part": part,
        "tracks": tracks,
        "allow_missing": allow_missing,
        "loss": loss,
        "bootstrap": bootstrap or None,
        "seed": seed,
        "compare_models": compare_models,
        "threads": threads,
    }
    if _tables.is_table(campaign):
        with _tables.campaign_of(campaign, conditions) as table:
            return Fit(wrapped(_calling.call("fit", "campaign", options, progress, given=table)))
    if conditions:
        raise InputError(f"{', '.join(conditions)}: conditions stand in the campaign, beside a table only")
    if _calling.is_path(campaign):
        return Fit(wrapped(_calling.call("fit", campaign, options, progress)))
    if not isinstance(campaign, dict):
        raise InputError(f"the campaign must be a path, a dict or a table, not {type(campaign).__name__}")
    return Fit(wrapped(_calling.call("fit", "campaign", options, progress, given=campaign)))
