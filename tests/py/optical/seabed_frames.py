"""Small missions of frames alone: pebbles on the ground, photographed along two overlapping lines."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFilter

from ssjs_cli.formats.number_table import FloatArray

WIDTH_PX, HEIGHT_PX = 240, 180
METRES_PER_PX = 0.01
STEP_PX = 55.0
LINE_STEPS = 9
LINE_GAP_PX = 130.0


def pebbles(width_px: int, height_px: int) -> Image.Image:
    rng = np.random.default_rng(3)
    ground = Image.new("L", (width_px, height_px), 110)
    draw = ImageDraw.Draw(ground)
    for _ in range(width_px * height_px // 180):
        x, y = rng.uniform(0, width_px), rng.uniform(0, height_px)
        across, along = rng.uniform(2, 9, 2)
        draw.ellipse((x - across, y - along, x + across, y + along), fill=int(rng.uniform(40, 220)))
    return ground.filter(ImageFilter.GaussianBlur(0.8))


def true_poses() -> FloatArray:
    """(n, 3) x ahead (up in the picture of the ground), y to the left, heading; the first is the origin. Along one line and back on
    another, the top of the picture always ahead, give or take."""
    steps = np.arange(LINE_STEPS) * STEP_PX
    ahead = np.concatenate((steps, steps[::-1]))
    left = np.concatenate((np.zeros(LINE_STEPS), np.full(LINE_STEPS, LINE_GAP_PX)))
    heading = 0.08 * np.sin(np.arange(2 * LINE_STEPS))
    return np.column_stack((METRES_PER_PX * ahead, METRES_PER_PX * left, heading))


def write_mission(directory: Path, settings: str = "") -> None:
    """Files are f00.png, ...; one frame a second."""
    frames = directory / "frames"
    frames.mkdir(parents=True)
    ground = pebbles(700, 900)
    rng = np.random.default_rng(4)
    names = []
    for number, (x_m, y_m, heading) in enumerate(true_poses().tolist()):
        column, row = 400.0 - y_m / METRES_PER_PX, 700.0 - x_m / METRES_PER_PX
        c, s = np.cos(heading), np.sin(heading)  # anticlockwise on the ground: the picture's axes turn with it
        middle_u, middle_v = (WIDTH_PX - 1) / 2, (HEIGHT_PX - 1) / 2
        to_ground = (c, s, column - c * middle_u - s * middle_v, -s, c, row + s * middle_u - c * middle_v)
        frame = np.asarray(ground.transform((WIDTH_PX, HEIGHT_PX), Image.Transform.AFFINE, to_ground, Image.Resampling.BILINEAR))
        noisy = np.clip(frame + 3.0 * rng.standard_normal(frame.shape), 0, 255).astype(np.uint8)
        names.append(f"f{number:02d}.png")
        Image.fromarray(noisy).save(frames / names[-1])
    lines = [f"{float(number)!r},{name}" for number, name in enumerate(names)]
    (frames / "index.csv").write_text("time_s,file\n" + "\n".join(lines) + "\n")
    (directory / "mission.toml").write_text(
        f'[mission]\nname = "pebbles"\n\n[settings.frames]\nmetres_per_px = {METRES_PER_PX}\n{settings}'
    )
