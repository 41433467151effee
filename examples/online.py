"""The pipeline fed one event at a time from Python: pose and covariance after every event."""

import numpy as np

from ssjs_cli import _core

mission = _core.simulate("grid-survey", seed=1)
pipeline = _core.Pipeline(mission["config"], seed=1)

scan_time_s = mission["scan_time_s"]
covariance = np.array([[0.1**2, 0.0, np.radians(1.0) ** 2]])
first = 0
for time_s, speed_m_s, steering_rad in zip(mission["control_time_s"], mission["speed_m_s"], mission["steering_rad"], strict=True):
    pose, _ = pipeline.feed_ackerman(time_s, speed_m_s, steering_rad)
    last = int(np.searchsorted(scan_time_s, time_s, side="right"))
    if last > first:  # the scan that came with this control
        rows = slice(first, last)
        pose, P = pipeline.feed_features(
            time_s, mission["range_m"][rows], mission["bearing_rad"][rows], np.repeat(covariance, last - first, axis=0)
        )
        if first == 0 or last == len(scan_time_s):
            print(f"{time_s:8.2f} s  x {pose[0]:7.2f} m  y {pose[1]:7.2f} m  sigma {np.sqrt(np.trace(P[:2, :2])):.3f} m")
        first = last
pipeline.finish()
