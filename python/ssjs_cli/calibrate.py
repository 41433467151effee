"""Calibration without a reference: what the observations alone say about the mounting of the sensor and the steering.

Each parameter is scanned coarse to fine for the smallest mean normalised innovation squared (NIS) per degree of freedom of the
scan updates. While the systematic parameters are scanned the side slip is set to zero, because slip noise would absorb what
they should explain. The slip noise itself cannot be found as a minimum, for more noise always lowers the NIS: the smallest
value is taken that gains most of what the largest one gains.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ssjs_cli import _core
from ssjs_cli.config import VEHICLE_KEY, Scalar, Settings, defaults
from ssjs_cli.errors import UserError
from ssjs_cli.formats.number_table import FloatArray, IntArray

NisOf = Callable[[Mapping[str, Scalar]], tuple[FloatArray, IntArray]]
Cost = Callable[[FloatArray, IntArray], float]


@dataclass(frozen=True)
class Scan:
    """The grid of one parameter: `points` values over centre +- half_width, then again around the best with a narrower grid."""

    key: str
    half_width: float
    points: int = 5
    refinements: int = 2


@dataclass(frozen=True)
class CalibrationPlan:
    scans: tuple[Scan, ...]
    slip_key: str
    slip_candidates: tuple[float, ...] = (0.0, 0.1, 0.2, 0.5, 1.0)
    slip_gain: float = 0.9


PLANS: Mapping[str, CalibrationPlan] = {
    "ackerman": CalibrationPlan(
        scans=(
            Scan("sensor.bearing_offset_rad", half_width=0.06),
            Scan("vehicle.ackerman.steering_offset_rad", half_width=0.015),
            Scan("vehicle.ackerman.steering_scale", half_width=0.09),
        ),
        slip_key="vehicle.ackerman.lateral_sigma_m_s",
    ),
    "unicycle": CalibrationPlan(
        scans=(Scan("sensor.bearing_offset_rad", half_width=0.06),),
        slip_key="vehicle.unicycle.lateral_sigma_m_s",
    ),
}


@dataclass(frozen=True)
class Evaluated:
    value: float
    cost: float


@dataclass
class Calibration:
    """`changes`: the settings found. `scanned`: every evaluated value with its cost, by key, in the order of evaluation."""

    changes: dict[str, float] = field(default_factory=dict)
    scanned: dict[str, list[Evaluated]] = field(default_factory=dict)


def mean_nis_per_dof(nis: FloatArray, dof: IntArray) -> float:
    """Sum of NIS over sum of degrees of freedom; infinite when nothing was paired at all."""
    total_dof = int(dof.sum())
    return float(nis.sum()) / total_dof if total_dof else float("inf")


def plan_for(settings: Settings) -> CalibrationPlan:
    kind = str(settings.values[VEHICLE_KEY])
    if kind not in PLANS:
        raise UserError(f"--calibrate: vehicles of the kind '{kind}' have nothing to calibrate; leave --calibrate out")
    return PLANS[kind]


def expected_runs(plan: CalibrationPlan) -> int:
    """How often a mission is run: a refined grid repeats the centre and, at its ends and every other point, values known already."""
    return sum(scan.points + scan.refinements * (scan.points // 2) for scan in plan.scans) + len(plan.slip_candidates)


def calibrate(settings: Settings, nis_of: NisOf, plan: CalibrationPlan, *, cost: Cost = mean_nis_per_dof) -> Calibration:
    """nis_of runs the mission with the given settings and gives the NIS and degrees of freedom of every scan update."""
    values: dict[str, Scalar] = dict(settings.values)
    calibration = Calibration()
    values[plan.slip_key] = 0.0
    for scan in plan.scans:
        best, evaluated = _scan(scan, values, nis_of, cost)
        values[scan.key] = best
        calibration.changes[scan.key] = best
        calibration.scanned[scan.key] = evaluated
    slip, evaluated = _smallest_sufficient_slip(plan, values, nis_of, cost)
    calibration.changes[plan.slip_key] = slip
    calibration.scanned[plan.slip_key] = evaluated
    return calibration


def _scan(scan: Scan, values: Mapping[str, Scalar], nis_of: NisOf, cost: Cost) -> tuple[float, list[Evaluated]]:
    """The value of the smallest cost; the last grid is finished by the vertex of a parabola through its best three."""
    known: dict[float, float] = {}
    centre, half_width = _number(values, scan.key), scan.half_width
    for _ in range(1 + scan.refinements):
        for value in _grid(scan, centre, half_width):
            if value not in known:
                known[value] = cost(*nis_of({**values, scan.key: value}))
        centre = min(known, key=lambda value: (known[value], abs(value - centre)))
        half_width /= 0.5 * (scan.points - 1)
    evaluated = [Evaluated(value, known[value]) for value in known]
    if not np.isfinite(known[centre]):
        raise UserError(f"--calibrate: with no value of {scan.key} was any observation paired; check the sensor and association settings")
    return _rounded(_parabola_vertex(sorted(known.items()), centre)), evaluated


def _number(values: Mapping[str, Scalar], key: str) -> float:
    value = values[key]
    if not isinstance(value, int | float):
        raise UserError(f"--calibrate: {key} = {value!r} is no number to start from")
    return float(value)


def _grid(scan: Scan, centre: float, half_width: float) -> list[float]:
    """Symmetric about the centre, inside what the setting allows."""
    grid = [_rounded(value) for value in np.linspace(centre - half_width, centre + half_width, scan.points).tolist()]
    return [value for value in grid if _is_allowed(scan.key, value)]


def _is_allowed(key: str, value: float) -> bool:
    return not any(violation.startswith(f"{key} ") for violation in _core.validate_config({**defaults(), key: value}))


def _rounded(value: float) -> float:
    """Nine decimals: the same scan gives the same text in config.toml."""
    return round(value, 9) + 0.0


def _parabola_vertex(curve: Sequence[tuple[float, float]], best: float) -> float:
    """Through the best value and its two neighbours; the best value itself at the end of the scan or without curvature."""
    position = [value for value, _ in curve].index(best)
    if position in (0, len(curve) - 1):
        return best
    (x0, y0), (x1, y1), (x2, y2) = curve[position - 1 : position + 2]
    denominator = (x1 - x0) * (y1 - y2) - (x1 - x2) * (y1 - y0)
    if not np.isfinite(denominator) or denominator == 0.0:
        return best
    vertex = x1 - 0.5 * ((x1 - x0) ** 2 * (y1 - y2) - (x1 - x2) ** 2 * (y1 - y0)) / denominator
    return vertex if x0 < vertex < x2 else best


def _smallest_sufficient_slip(
    plan: CalibrationPlan, values: Mapping[str, Scalar], nis_of: NisOf, cost: Cost
) -> tuple[float, list[Evaluated]]:
    evaluated = [Evaluated(slip, cost(*nis_of({**values, plan.slip_key: slip}))) for slip in plan.slip_candidates]
    gain = evaluated[0].cost - min(entry.cost for entry in evaluated)
    for entry in evaluated:
        if evaluated[0].cost - entry.cost >= plan.slip_gain * gain:
            return entry.value, evaluated
    return evaluated[-1].value, evaluated
