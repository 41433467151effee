"""Victoria Park from the raw logs: time, steps and accuracy of one configuration, its own association, no GPS in the filter.

SSJS_DATA=... python benchmarks/victoria_park.py --rounds 5
"""

import argparse
import time
from typing import Any

import numpy as np
from step_times import data_directory, machine_text, quantile_text, steady_step_times

from ssjs_cli import _core
from ssjs_cli.config import Settings, layer_from_assignments, layer_from_tables, resolve
from ssjs_cli.formats.mission import Mission
from ssjs_cli.formats.victoria_park import read_victoria_park
from ssjs_cli.mission_run import build_log

SEED = 1


def trajectory_text(mission: Mission, time_s: Any, pose: Any) -> str:
    reference = mission.reference
    description = reference.description
    error = _core.trajectory_error(
        time_s,
        pose,
        reference.fixes.time_s,
        reference.fixes.position_m,
        None,
        np.array([description.lever_arm_forward_m, description.lever_arm_left_m]),
        description.alignment,
        description.outlier_m,
        description.max_gap_s,
    )
    return (
        f"RMSE {error['rmse_m']:.3f} m, median {error['median_m']:.3f} m, {error['outliers']} of {error['outliers'] + error['compared']} "
        f"fixes beyond {description.outlier_m:g} m rejected"
    )


def settings_of(mission: Mission, assignments: list[str]) -> Settings:
    return resolve([layer_from_tables(mission.settings, "victoria-park"), layer_from_assignments(assignments)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="repetitions; medians are shown")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="assignments", help="a setting, several times")
    arguments = parser.parse_args()

    directory = data_directory() / "victoria_park"
    begin_s = time.process_time()
    mission = read_victoria_park(directory)
    read_s = time.process_time() - begin_s
    settings = settings_of(mission, arguments.assignments)
    lost: list[str] = []
    begin_s = time.process_time()
    log = build_log(mission, settings, directory, lost)
    build_s = time.process_time() - begin_s

    run_s, step_time_us = [], []
    for _ in range(arguments.rounds):
        begin_s = time.process_time()
        result = _core.run(dict(settings.values), log, SEED, None)
        run_s.append(time.process_time() - begin_s)
        step_time_us.append(np.asarray(result["step_time_us"]))
    mission_s = float(result["time_s"][-1] - result["time_s"][0])
    steps = steady_step_times(step_time_us)
    is_scan = np.isin(result["time_s"], mission.scans.time_s)
    median_s = float(np.median(run_s))
    counters, timing = result["counters"], result["timing"]

    print(machine_text())
    print(f"ssjs {_core.version()}, Victoria Park, {len(steps)} events, {mission_s:.0f} s, {arguments.rounds} runs, processor time")
    print(f"run {median_s:.2f} s, the median ({min(run_s):.2f} to {max(run_s):.2f}): {mission_s / median_s:.0f} x real time")
    with_reading_s = median_s + read_s + build_s
    print(f"reading the files {read_s:.2f} s, building the log {build_s:.2f} s: with both {mission_s / with_reading_s:.0f} x real time")
    print(f"all steps, wall time: {quantile_text(steps)}")
    print(f"events at a scan's time: {quantile_text(steps[is_scan])}")
    parts = ("time_local_s", "time_association_s", "time_global_s", "time_other_s")
    print("wall time of the last run by part: " + ", ".join(f"{part[5:-2]} {timing[part]:.2f} s" for part in parts))
    print(f"online: {trajectory_text(mission, result['time_s'], result['online_pose'])}")
    print(f"final: {trajectory_text(mission, result['time_s'], result['pose'])}")
    nis = _core.consistency_summary(np.asarray(result["updates"]["nis"]), np.asarray(result["updates"]["dof"], dtype=np.int64))
    fusion_chi2_per_dof = result["fusion_chi2"] / max(1, counters["fusion_dof"])
    print(f"fusion chi2/dof {fusion_chi2_per_dof:.2f}, scan NIS/dof {nis['mean_per_dof']:.2f}")
    print(
        f"{counters['submaps']} submaps, {len(result['live_maps'])} live maps, {counters['landmarks']} landmarks in them, "
        f"{counters['fusions']} fusions"
    )
    for text in lost:
        print(f"not used: {text}")


if __name__ == "__main__":
    main()
