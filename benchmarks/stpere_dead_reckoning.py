"""Dead reckoning of the Sant Pere log: DVL and AHRS as imported, against DGPS. Shows that signs, units, clocks and mountings are right.

    python benchmarks/stpere_dead_reckoning.py MISSION_DIR

The offset of the AHRS's yaw from north is estimated from the first quarter of the log alone; the error is of all fixes, once with the
origin where it fits all of them best, and once with the first fix as the origin.
"""

import argparse
import json
import math
from pathlib import Path

import numpy as np

from ssjs_cli.formats.bottom_track import bottom_track, positions_at, turned, yaw_between
from ssjs_cli.formats.mission import Fixes, read_mission
from ssjs_cli.formats.navigation import UnderwaterNavigation
from ssjs_cli.formats.number_table import FloatArray


def dead_reckoning(navigation: UnderwaterNavigation) -> tuple[FloatArray, FloatArray]:
    """Times (n,) and positions (n, 2) in the horizontal frame of the AHRS."""
    if navigation.velocity is None:
        raise SystemExit("the mission holds no dvl.csv")
    return bottom_track(navigation.attitude, navigation.velocity)


def score(time_s: FloatArray, position: FloatArray, fixes: Fixes, quarter: float = 0.25) -> dict[str, float]:
    inside = (fixes.time_s >= time_s[0]) & (fixes.time_s <= time_s[-1])
    fix_time_s, reference = fixes.time_s[inside], fixes.position_m[inside]
    at_fix = positions_at(fix_time_s, time_s, position)
    early = fix_time_s <= time_s[0] + quarter * (time_s[-1] - time_s[0])
    offset = yaw_between(at_fix[early], reference[early])
    level = turned(at_fix, offset)
    error = level - level.mean(axis=0) - (reference - reference.mean(axis=0))
    from_start = level - level[0] - (reference - reference[0])
    return {
        "fixes": int(inside.sum()),
        "fixes_used_for_offset": int(early.sum()),
        "yaw_offset_deg": round(math.degrees(offset), 2),
        "rmse_m": _rms(error),
        "max_m": round(float(np.hypot(*error.T).max()), 3),
        "rmse_from_first_fix_m": _rms(from_start),
        "final_from_first_fix_m": round(float(np.hypot(*from_start[-1])), 3),
    }


def _rms(error: FloatArray) -> float:
    return round(float(np.sqrt((error**2).sum(axis=1).mean())), 3)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path)
    mission = read_mission(parser.parse_args().mission)
    if mission.navigation is None or mission.reference.fixes is None:
        raise SystemExit("the mission needs imu.csv, dvl.csv and reference_fixes.csv")
    print(json.dumps(score(*dead_reckoning(mission.navigation), mission.reference.fixes), indent=2))


if __name__ == "__main__":
    main()
