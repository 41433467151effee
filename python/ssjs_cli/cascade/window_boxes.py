"""From the box of an object to the box of a window, and back."""

from ssjs_cli.formats.annotations.boxes import Box


def window_box(box: Box, margin: float, window_px: tuple[int, int], picture_px: tuple[int, int]) -> Box | None:
    """The object's box with `margin` of its size on each side, grown to the window's proportions about its centre and, where it
    reaches over the border of the picture, moved inside. None where it is larger than the picture. Sizes are (width, height)."""
    left, top, width, height = box
    scale = max((1 + 2 * margin) * width / window_px[0], (1 + 2 * margin) * height / window_px[1])
    grown = (max(1, round(scale * window_px[0])), max(1, round(scale * window_px[1])))
    if grown[0] > picture_px[0] or grown[1] > picture_px[1]:
        return None
    x = round(left + width / 2 - grown[0] / 2)
    y = round(top + height / 2 - grown[1] / 2)
    return min(max(x, 0), picture_px[0] - grown[0]), min(max(y, 0), picture_px[1] - grown[1]), grown[0], grown[1]


def object_length(window_px: int, margin: float) -> int:
    """What is left of a window's side without the margin."""
    return max(1, round(window_px / (1 + 2 * margin)))


def object_box(window: Box, margin: float, *, mirrored: bool = False) -> Box:
    """Where the object of a detection lies. An odd rest lies right of it; mirrored: left of it, as mirroring the picture would have it."""
    left, top, width, height = window
    inner_width, inner_height = object_length(width, margin), object_length(height, margin)
    rest = width - inner_width
    return left + (rest - rest // 2 if mirrored else rest // 2), top + (height - inner_height) // 2, inner_width, inner_height


def intersection_over_union(one: Box, other: Box) -> float:
    width = min(one[0] + one[2], other[0] + other[2]) - max(one[0], other[0])
    height = min(one[1] + one[3], other[1] + other[3]) - max(one[1], other[1])
    if width <= 0 or height <= 0:
        return 0.0
    common = width * height
    return common / (one[2] * one[3] + other[2] * other[3] - common)
