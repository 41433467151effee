"""A mission of frames alone as one with odometry and landmarks: frames are registered with those that follow and, as the track becomes
better known, with others that show the same ground. docs/math/optical.md (V-15..V-21)"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from ssjs_cli import _core
from ssjs_cli.errors import UserError
from ssjs_cli.formats.frames import FrameIndex
from ssjs_cli.formats.number_table import FloatArray, IntArray
from ssjs_cli.optical.frame_reading import UsableFrames, usable_frames
from ssjs_cli.optical.frame_settings import FrameSettings

LEAST_MATCHES = 4
#: Usual intervals between frames; what is longer is a pause.
PAUSE_INTERVALS = 10.0
FrameProgress = Callable[[float], bool]
Estimator = Callable[[Any], Mapping[str, Any]]


@dataclass
class PlanarSurvey:
    """links: (earlier, later) -> registration, of frames with their lens taken out; pixel_length (n,): of each frame on the ground;
    seen: what was seen of the landmarks, the number of a frame with pixels and identities."""

    frames: UsableFrames
    lens: dict[str, Any] | None
    lens_is_estimated: bool
    links: dict[tuple[int, int], dict[str, Any]]
    log: Any = None
    pixel_length: FloatArray = field(default_factory=lambda: np.zeros(0))
    registered: list[bool] = field(default_factory=list)
    landmarks: int = 0
    seen: list[tuple[int, FloatArray, IntArray]] = field(default_factory=list)
    rounds: int = 0

    @property
    def revisits(self) -> int:
        return sum(later - earlier > 1 for earlier, later in self.links)

    def connected(self) -> list[int]:
        """The frames of the largest set that registrations connect; of the others the place is a guess."""
        group = list(range(len(self.frames.features)))

        def representative(number: int) -> int:
            while group[number] != number:
                number = group[number]
            return number

        for first, second in sorted(self.links):
            low, high = sorted((representative(first), representative(second)))
            group[high] = low
        members: dict[int, list[int]] = {}
        for number in range(len(group)):
            members.setdefault(representative(number), []).append(number)
        return max(members.values(), key=len)

    def placed_on_map(self, pose: FloatArray) -> FloatArray:
        """(n, 3, 3) pixels of each frame, lens corrected, -> x, y of the global frame. (V-16)"""
        width_px, height_px = self.frames.size_px
        placed = np.zeros((len(pose), 3, 3))
        for number, (x, y, heading) in enumerate(pose.tolist()):
            c, s = np.cos(heading), np.sin(heading)
            body_H_pixel = self.pixel_length[number] * np.array([[0.0, -1.0, (height_px - 1) / 2], [-1.0, 0.0, (width_px - 1) / 2]])
            placed[number] = np.vstack((np.array([[c, -s], [s, c]]) @ body_H_pixel, [0.0, 0.0, 1.0]))
            placed[number, :2, 2] += (x, y)
        return placed


def planar_survey(
    index: FrameIndex, settings: FrameSettings, seed: int, lost: list[str], estimate: Estimator, progress: FrameProgress
) -> PlanarSurvey:
    """estimate: a log -> the result of the estimator."""
    calibration = None if index.calibration is None else asdict(index.calibration)
    reader = settings.reader(calibration)
    frames = usable_frames(index, reader, lost, lambda fraction: progress(0.5 * fraction))
    survey = PlanarSurvey(frames, calibration, False, _sequence(frames, settings))
    _keep_longest_part(survey, lost)
    if not survey.links:
        raise UserError(f"{index.folder}: no two frames that follow each other show the same ground; check their order and their overlap")
    if calibration is None and settings.own("estimate_lens"):
        _take_lens_out(survey, settings)
    tried: set[tuple[int, int]] = set(survey.links)
    rounds = int(settings.own("rounds"))
    for number in range(rounds):
        survey.rounds = number + 1
        _build_log(survey, settings, None, seed)
        if number + 1 == rounds:
            break
        result = estimate(survey.log)
        if not progress(0.5 + 0.5 * number / rounds):
            raise KeyboardInterrupt
        if not _look_along(survey, settings, result, tried):
            break
    if settings.own("landmarks") == "mosaic-points":
        pose, _ = poses_at_frames(estimate(survey.log), survey.frames.time_s)
        _build_log(survey, settings, pose, seed)
    return survey


def poses_at_frames(result: Mapping[str, Any], time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, 3) final poses at the frames, and the variance (n,) of their positions in all."""
    rows = np.searchsorted(np.asarray(result["time_s"]), time_s, side="right") - 1
    covariance = np.asarray(result["covariance"])[rows]
    return np.asarray(result["pose"])[rows], covariance[:, 0] + covariance[:, 3]


def _sequence(frames: UsableFrames, settings: FrameSettings) -> dict[tuple[int, int], dict[str, Any]]:
    links = {}
    for number in range(len(frames.features) - 1):
        found = _core.register_frames(frames.features[number], frames.features[number + 1], settings.of_frames)
        if found is not None:
            links[number, number + 1] = found
    return links


def _keep_longest_part(survey: PlanarSurvey, lost: list[str]) -> None:
    """Nothing is known of where the vehicle went in a long pause."""
    time_s = survey.frames.time_s
    intervals_s = np.diff(time_s)
    pause_s = PAUSE_INTERVALS * float(np.median(intervals_s))
    ends = [row + 1 for row, interval in enumerate(intervals_s.tolist()) if interval > pause_s and (row, row + 1) not in survey.links]
    if not ends:
        return
    begin, end = max(pairwise([0, *ends, len(time_s)]), key=lambda part: part[1] - part[0])
    lost.append(
        f"{len(time_s) - (end - begin)} of {len(time_s)} frames lie beyond a pause of more than {pause_s:.0f} s and were not used; "
        "make them a mission of their own"
    )
    survey.frames = survey.frames.part(begin, end)
    survey.links = {(a - begin, b - begin): found for (a, b), found in survey.links.items() if begin <= a and b < end}


def _take_lens_out(survey: PlanarSurvey, settings: FrameSettings) -> None:
    positions = survey.frames.positions_px()
    pairs = [
        (positions[first][found["inliers"][:, 0]], positions[second][found["inliers"][:, 1]])
        for (first, second), found in survey.links.items()
    ]
    found = _core.estimate_lens(pairs, *survey.frames.size_px, float(settings.values["matching.tolerance_px"] or 0.0))
    if found is None:
        return
    survey.lens, survey.lens_is_estimated = found["calibration"], True
    survey.frames = survey.frames.straightened(found["calibration"])
    survey.links = _sequence(survey.frames, settings)


def _look_along(survey: PlanarSurvey, settings: FrameSettings, result: Mapping[str, Any], tried: set[tuple[int, int]]) -> bool:
    """Registers frames that may show the same ground; whether any two did."""
    pose, variance = poses_at_frames(result, survey.frames.time_s)
    width = float(np.median(survey.pixel_length)) * survey.frames.size_px[0]
    found_any = False
    for earlier, later in _core.overlapping_frames(settings.of_motion, pose, variance, width):
        if (earlier, later) in tried:
            continue
        tried.add((earlier, later))
        found = _core.register_frames(survey.frames.features[earlier], survey.frames.features[later], settings.of_frames)
        if found is not None:
            survey.links[earlier, later] = found
            found_any = True
    return found_any


def _build_log(survey: PlanarSurvey, settings: FrameSettings, mosaic_pose: FloatArray | None, seed: int) -> None:
    """Odometry and landmarks out of different matches, so that no match counts twice. mosaic_pose: of the frames, where landmarks are
    random points of their mosaic."""
    positions = survey.frames.positions_px()
    size = survey.frames.size_px
    ordered = sorted(survey.links.items(), key=lambda link: (link[0][1] - link[0][0] > 1, link[0]))  # those in sequence first
    pairs = [(a, b, positions[a][found["inliers"][:, 0]], positions[b][found["inliers"][:, 1]]) for (a, b), found in ordered]
    survey.pixel_length = _core.pixel_lengths(settings.of_motion, len(positions), pairs, *size)
    links = [(a, b, found["inliers"].tolist()) for (a, b), found in ordered]
    tracks = [np.asarray(rows) for rows in _core.keypoint_tracks([len(p) for p in positions], links)]
    chosen = np.asarray(_core.chosen_tracks([rows.tolist() for rows in tracks], int(settings.own("landmarks_per_frame"))))
    survey.landmarks = len(chosen)
    free = []
    for (a, b), found in ordered:
        if b == a + 1:
            rows = found["inliers"][~np.isin(tracks[a][found["inliers"][:, 0]], chosen)]
            if len(rows) >= LEAST_MATCHES:
                free.append((a, b, positions[a][rows[:, 0]], positions[b][rows[:, 1]]))
    increments = _core.frame_increments(settings.of_motion, survey.frames.time_s, survey.pixel_length, free, *size)
    survey.registered = list(increments["registered"])
    survey.log = _core.MissionLog()
    motion = increments["motion"]
    columns = [np.ascontiguousarray(column) for column in motion.T]
    survey.log.add_increments(survey.frames.time_s[1:], *columns, increments["covariance"])
    if mosaic_pose is None:
        survey.seen = [
            (number, positions[number][np.isin(rows, chosen)], rows[np.isin(rows, chosen)]) for number, rows in enumerate(tracks)
        ]
    else:
        survey.seen = _mosaic_points(survey, settings, mosaic_pose, seed)
        survey.landmarks = len(np.unique(np.concatenate([ids for _, _, ids in survey.seen])))
    _add_sightings(survey, settings)


def _mosaic_points(survey: PlanarSurvey, settings: FrameSettings, pose: FloatArray, seed: int) -> list[tuple[int, FloatArray, IntArray]]:
    links = [(a, b, found["second_H_first"]) for (a, b), found in survey.links.items()]
    placed = list(survey.placed_on_map(pose))
    table = _core.mosaic_points(placed, *survey.frames.size_px, links, int(settings.own("mosaic_points")), seed)
    return [(n, table["pixel"][table["frame"] == n], table["point"][table["frame"] == n]) for n in range(len(pose))]


def _add_sightings(survey: PlanarSurvey, settings: FrameSettings) -> None:
    """Pixels as ranges and bearings from the middle of the frame; near it a bearing says nothing, and the point is left out."""
    width_px, height_px = survey.frames.size_px
    middle = np.array([(width_px - 1) / 2, (height_px - 1) / 2])
    columns: list[FloatArray] = []
    ids: list[IntArray] = []
    for number, pixel, identity in survey.seen:
        offset = pixel - middle
        range_px = np.hypot(offset[:, 0], offset[:, 1])
        kept = range_px > float(settings.own("least_range")) * width_px
        offset, range_px = offset[kept], range_px[kept]
        length = survey.pixel_length[number]
        sigma_px = float(settings.own("pixel_sigma_px"))
        columns.append(
            np.column_stack(
                (
                    np.full(len(range_px), survey.frames.time_s[number]),
                    length * range_px,
                    np.arctan2(-offset[:, 0], -offset[:, 1]),
                    np.full(len(range_px), (length * sigma_px) ** 2),
                    (sigma_px / range_px) ** 2,
                )
            )
        )
        ids.append(identity[kept])
    table = np.concatenate(columns)
    covariance = np.column_stack((table[:, 3], np.zeros(len(table)), table[:, 4]))
    time_s, range_m, bearing_rad = (np.ascontiguousarray(table[:, column]) for column in range(3))
    survey.log.add_features(time_s, range_m, bearing_rad, covariance, np.concatenate(ids).astype(np.int64).tolist())
