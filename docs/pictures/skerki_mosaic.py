"""The mosaic of docs/skerki.md from a finished run.

python docs/pictures/skerki_mosaic.py RUN_DIR docs/pictures/skerki_mosaic.jpg
"""

import sys
from pathlib import Path

from PIL import Image

WIDTH_PX = 1800
QUALITY = 82


def main(run: Path, to: Path) -> None:
    with Image.open(run / "pictures" / "mosaic.jpg") as picture:
        height_px = round(picture.height * WIDTH_PX / picture.width)
        picture.resize((WIDTH_PX, height_px), Image.Resampling.LANCZOS).save(to, quality=QUALITY, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
