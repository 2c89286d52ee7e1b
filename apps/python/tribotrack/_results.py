"""The results' types, for type checkers: plain dicts at run time. Units stand in the names."""

from __future__ import annotations

from typing import Any, Optional, TypedDict

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class SteadyMotion(TypedDict):
    alpha_rad: Optional[float]  # None where the part circles without drifting
    v_mm_s: float


class Simulation(TypedDict):
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
    steady: Optional[SteadyMotion]  # None where no unique steady motion exists


class Track(TypedDict, total=False):
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
    gate: Floats  # where a lamp is given
    rho_xy_mm: Floats  # where part and mark lie in different planes
    marker_x_mm: Floats
    marker_y_mm: Floats
    marker_sigma_mm: Floats
    meta: dict[str, Any]  # what stands in T.csv.meta.json
