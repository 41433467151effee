"""The section of a camera mission: the mosaic as large as the page, matches between frames, and what was predicted and measured in them."""

from dataclasses import dataclass, field

from ssjs_cli.report.frame_files import FramePictures
from ssjs_cli.report.number_text import count_text, percent_text, seconds_text
from ssjs_cli.report.picture_data import jpeg_url

MOSAIC_WIDTH_PX = 2000
MOSAIC_QUALITY = 78
FRAME_QUALITY = 82


@dataclass(frozen=True)
class CaptionedPicture:
    url: str
    caption: str


@dataclass
class FrameSection:
    mosaic: CaptionedPicture | None = None
    matches: list[CaptionedPicture] = field(default_factory=list)
    sightings: list[CaptionedPicture] = field(default_factory=list)
    note: str = ""


def frame_section(pictures: FramePictures | None) -> FrameSection | None:
    if pictures is None:
        return None
    section = FrameSection(note=_note(pictures))
    if pictures.mosaic is not None:
        section.mosaic = CaptionedPicture(
            jpeg_url(pictures.mosaic.path, MOSAIC_QUALITY, MOSAIC_WIDTH_PX),
            f"Frames where the final track has them, their lens and the lamps' light taken out, {pictures.mosaic.width_px} × "
            f"{pictures.mosaic.height_px} pixels in {pictures.folder.name}/{pictures.mosaic.path.name}. White was not seen.",
        )
    for entry in pictures.matches:
        count = count_text(int(entry.get("matches", 0)))
        apart = seconds_text(float(entry.get("seconds_apart", 0.0)))
        text = f"{entry.get('first', '')} and {entry.get('second', '')}, {apart} apart: {count} matches agree."
        section.matches.append(CaptionedPicture(jpeg_url(pictures.folder / entry["picture"], FRAME_QUALITY), text))
    for entry in pictures.sightings:
        text = f"{entry.get('frame', '')}: {count_text(int(entry.get('sightings', 0)))} landmarks."
        section.sightings.append(CaptionedPicture(jpeg_url(pictures.folder / entry["picture"], FRAME_QUALITY), text))
    return section


def _note(pictures: FramePictures) -> str:
    given, used, with_region = (pictures.frames.get(key) for key in ("given", "used", "with_region"))
    if given is None or used is None or with_region is None or used == 0:
        return ""
    return (
        f"{count_text(used)} of {count_text(given)} frames were used; {count_text(with_region)} of them "
        f"({percent_text(with_region / used)}) have a region of interest."
    )
