"""Half real missions: posts that were never there, as a scanning sonar on the real vehicle would have seen them from where its reference
says it was. What the filter gets besides is the real log. Nothing of the reference goes into the filter."""

import math
from dataclasses import dataclass

import numpy as np

from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import UNKNOWN_LANDMARK, BodyPoints, SurveyedLandmarks
from ssjs_cli.formats.number_table import FloatArray, IntArray
from ssjs_cli.formats.tum import PoseSeries

MIN_DISTANCE_M = 2.0
MAX_TRIES_PER_POST = 1000
PLACES, ECHOES, CLUTTER = range(3)


@dataclass(frozen=True)
class ScanningSonar:
    """A narrow beam that turns about the vehicle's down axis, one ping a step. It tells range and bearing; an echo comes from anywhere
    along a post, so that its height says little. Clutter lies evenly over the circle that it sees."""

    step_rad: float = math.pi / 100.0
    ping_interval_s: float = 0.069
    min_range_m: float = 1.0
    max_range_m: float = 30.0
    range_sigma_m: float = 0.15
    bearing_sigma_rad: float = math.radians(1.5)
    height_sigma_m: float = 0.5
    detection_probability: float = 0.8
    clutter_per_turn: float = 1.0

    @property
    def pings_per_turn(self) -> int:
        return round(2.0 * math.pi / self.step_rad)


@dataclass(frozen=True)
class SeenPosts:
    """Sightings in the order of time, clutter among them without an identity; `clutter`: how many those are."""

    points: BodyPoints
    landmarks: SurveyedLandmarks
    clutter: int


def simulate_posts(vehicle: PoseSeries, count: int, seed: int, sonar: ScanningSonar | None = None) -> SeenPosts:
    """`count` posts in the sonar's reach of the true poses `vehicle` (x, y, heading clockwise, north-east-down), and what is seen of them
    between the first and the last pose."""
    sonar = sonar or ScanningSonar()
    posts = place_posts(vehicle.pose[:, :2], count, sonar, np.random.default_rng([seed, PLACES]))
    ping_s, beam_rad, pose = _pings(vehicle, sonar)
    time_s, range_m, bearing_rad, ids = _echoes(ping_s, beam_rad, pose, posts, sonar, np.random.default_rng([seed, ECHOES]))
    random = np.random.default_rng([seed, CLUTTER])
    clutter = int(random.poisson(sonar.clutter_per_turn * len(ping_s) / sonar.pings_per_turn))
    at = random.integers(0, len(ping_s), clutter)
    time_s = np.concatenate([time_s, ping_s[at]])
    range_m = np.concatenate([range_m, np.sqrt(random.uniform(sonar.min_range_m**2, sonar.max_range_m**2, clutter))])
    bearing_rad = np.concatenate([bearing_rad, beam_rad[at]])
    ids = np.concatenate([ids, np.full(clutter, UNKNOWN_LANDMARK)])
    height_m = random.normal(0.0, sonar.height_sigma_m, len(time_s))
    order = np.argsort(time_s, kind="stable")
    points = _points(time_s[order], range_m[order], bearing_rad[order], height_m[order], ids[order], sonar)
    return SeenPosts(points, SurveyedLandmarks(np.arange(count), posts), clutter)


def place_posts(track_m: FloatArray, count: int, sonar: ScanningSonar, random: np.random.Generator) -> FloatArray:
    """(count, 2), evenly over the ground that lies in the sonar's reach of the track (n, 2), no two nearer than MIN_DISTANCE_M."""
    low, high = track_m.min(axis=0) - sonar.max_range_m, track_m.max(axis=0) + sonar.max_range_m
    posts: list[FloatArray] = []
    for _ in range(MAX_TRIES_PER_POST * count):
        if len(posts) == count:
            break
        place = random.uniform(low, high)
        nearest_m = float(np.hypot(*(track_m - place).T).min())
        if MIN_DISTANCE_M <= nearest_m <= sonar.max_range_m and all(math.dist(place, other) >= MIN_DISTANCE_M for other in posts):
            posts.append(place)
    if len(posts) < count:
        raise UserError(f"{count} landmarks do not fit around the track; ask for fewer than {len(posts)}")
    return np.array(posts)


def _pings(vehicle: PoseSeries, sonar: ScanningSonar) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times (n,), beams from ahead towards starboard (n,) and true poses (n, 3)."""
    ping_s = np.arange(vehicle.time_s[0], vehicle.time_s[-1], sonar.ping_interval_s)
    beam_rad = sonar.step_rad * (np.arange(len(ping_s)) % sonar.pings_per_turn) - math.pi
    columns = [vehicle.pose[:, 0], vehicle.pose[:, 1], np.unwrap(vehicle.pose[:, 2])]
    return ping_s, beam_rad, np.column_stack([np.interp(ping_s, vehicle.time_s, column) for column in columns])


def _echoes(
    ping_s: FloatArray, beam_rad: FloatArray, pose: FloatArray, posts: FloatArray, sonar: ScanningSonar, random: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Times, ranges, bearings and posts of the echoes: at most one of a post in half a turn, at the ping whose beam covers it."""
    pings: list[int] = []
    ids: list[int] = []
    for post, place in enumerate(posts):
        range_m, bearing_rad = _polar(place - pose[:, :2], pose[:, 2])
        beside_rad = np.abs(np.angle(np.exp(1j * (beam_rad - bearing_rad))))
        seen = (beside_rad <= 0.5 * sonar.step_rad) & (range_m >= sonar.min_range_m) & (range_m <= sonar.max_range_m)
        last = -sonar.pings_per_turn
        for ping in np.flatnonzero(seen).tolist():
            if ping - last <= sonar.pings_per_turn // 2:
                continue
            last = ping
            if random.random() < sonar.detection_probability:
                pings.append(ping)
                ids.append(post)
    at = np.array(pings, dtype=np.int64)
    seen_posts = np.array(ids, dtype=np.int64)
    range_m, bearing_rad = _polar(posts[seen_posts] - pose[at, :2], pose[at, 2])
    return (
        ping_s[at],
        np.maximum(range_m + random.normal(0.0, sonar.range_sigma_m, len(at)), 0.5 * sonar.min_range_m),
        bearing_rad + random.normal(0.0, sonar.bearing_sigma_rad, len(at)),
        seen_posts,
    )


def _polar(offset_m: FloatArray, heading_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    range_m: FloatArray = np.hypot(offset_m[:, 0], offset_m[:, 1])
    bearing_rad: FloatArray = np.arctan2(offset_m[:, 1], offset_m[:, 0]) - heading_rad
    return range_m, bearing_rad


def _points(
    time_s: FloatArray, range_m: FloatArray, bearing_rad: FloatArray, height_m: FloatArray, ids: IntArray, sonar: ScanningSonar
) -> BodyPoints:
    cos, sin, zero = np.cos(bearing_rad), np.sin(bearing_rad), np.zeros(len(time_s))
    along, across = sonar.range_sigma_m**2, (range_m * sonar.bearing_sigma_rad) ** 2
    covariance = [
        cos**2 * along + sin**2 * across,
        cos * sin * (along - across),
        zero,
        sin**2 * along + cos**2 * across,
        zero,
        zero + sonar.height_sigma_m**2,
    ]
    return BodyPoints(time_s, np.column_stack([range_m * cos, range_m * sin, height_m]), ids, np.column_stack(covariance))
