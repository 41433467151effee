"""The map of a region: tracks of all missions and the contacts that they know together, north up."""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ssjs_cli.formats.geojson import ellipse_outline
from ssjs_cli.report import figure_style as style
from ssjs_cli.report.figure_style import Figure, FloatArray, Trace

if TYPE_CHECKING:
    from ssjs_cli.studies.season_map import PlacedMission, Region, SeasonContact

HEIGHT_PX = 720
#: Above so many points the page would be slow: tracks are drawn by their ends, contacts that one mission saw are left to the table.
MAX_TRACK_POINTS = 60_000
MAX_CONTACTS = 8_000
MAX_ELLIPSES = 600
DECIMALS = 2


def season_figure(region: "Region", outliers: Collection[str]) -> Figure:
    """outliers: names of missions that stand out."""
    usual = [mission for mission in region.missions if mission.name not in outliers]
    odd = [mission for mission in region.missions if mission.name in outliers]
    several = [contact for contact in region.contacts if len(contact.seen_by) > 1]
    single = [contact for contact in region.contacts if len(contact.seen_by) == 1][: max(MAX_CONTACTS - len(several), 0)]
    traces = [
        *_tracks(usual, "missions", style.DEAD_RECKONING, 1.0),
        *_tracks(odd, "missions that stand out", style.OUTSIDE, 1.8),
        *_ellipses([*several, *single]),
        *_points(single, "seen by one mission", "rgba(42,111,187,0.45)", 6.0),
        *_points(several, "seen by several", style.INK, 8.0),
    ]
    axes = {"scaleanchor": "x", "scaleratio": 1.0}
    return {
        "data": traces,
        "layout": style.layout(HEIGHT_PX, xaxis=style.axis("east [m]"), yaxis=style.axis("north [m]", **axes), dragmode="pan"),
    }


def _tracks(missions: Sequence["PlacedMission"], name: str, colour: str, width_px: float) -> list[Trace]:
    """One trace, with a gap between two missions."""
    if not missions:
        return []
    total = sum(len(mission.track_m) for mission in missions)
    step = max(1, -(-total // MAX_TRACK_POINTS))
    gap = np.full((1, 2), np.nan)
    pieces: list[FloatArray] = []
    for mission in missions:
        rows = np.union1d(np.arange(0, len(mission.track_m), step), [len(mission.track_m) - 1])
        pieces += [mission.track_m[rows], gap]
    points = np.concatenate(pieces)
    return [_drawn(points, "lines", name, line={"color": colour, "width": width_px}, hoverinfo="skip", opacity=0.75)]


def _points(contacts: Sequence["SeasonContact"], name: str, colour: str, size_px: float) -> list[Trace]:
    if not contacts:
        return []
    points = np.array([contact.position_m[:2] for contact in contacts])
    texts = [_text(contact) for contact in contacts]
    marker = {"color": colour, "size": size_px, "line": {"color": "#ffffff", "width": 1}}
    return [_drawn(points, "markers", name, marker=marker, text=texts, hoverinfo="text")]


def _text(contact: "SeasonContact") -> str:
    xx, xy, yy = contact.covariance_m2
    sigma_m = float(np.sqrt(max(np.linalg.eigvalsh([[xx, xy], [xy, yy]])[-1], 0.0)))
    names = [f"{mission}, landmark {number}" for mission, number in contact.seen_by[:8]]
    more = [f"and {len(contact.seen_by) - 8} more"] if len(contact.seen_by) > 8 else []
    seen = f"seen by {len(contact.seen_by)} mission{'s' if len(contact.seen_by) > 1 else ''}"
    return "<br>".join([f"<b>contact {contact.id}</b>, {seen}", f"σ {sigma_m:.2f} m, depth {contact.position_m[2]:.1f} m", *names, *more])


def _ellipses(contacts: Sequence["SeasonContact"]) -> list[Trace]:
    """95 %, of the contacts known best from several missions first; all in one trace."""
    if not contacts:
        return []
    gap = np.full((1, 2), np.nan)
    pieces = []
    for contact in contacts[:MAX_ELLIPSES]:
        pieces += [ellipse_outline(np.array(contact.position_m[:2]), contact.covariance_m2)[::2], gap]
    return [_drawn(np.concatenate(pieces), "lines", "95 % ellipse", line={"color": style.BAND, "width": 1.0}, hoverinfo="skip")]


def _drawn(points: FloatArray, mode: str, name: str, **more: object) -> Trace:
    """points (n, 2) north, east."""
    x, y = style.listed(points[:, 1], DECIMALS), style.listed(points[:, 0], DECIMALS)
    return {"type": "scatter", "mode": mode, "x": x, "y": y, "name": name, **more}
