"""Detection beside cv2.CascadeClassifier: OpenCV's frontal-face model on 1920 x 932 pixels, the same scales, one thread and two.

    PYTHONPATH=python python benchmarks/cascade_detection.py

Rounds are interleaved; times are processor time, of all threads together.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from ssjs_cli import _core

MODEL = cv2.data.haarcascades + "haarcascade_frontalface_default.xml"
CONFIG = {"scale_factor": 1.1, "min_neighbours": 3}


def cpu_ms(work: Callable[[], Any]) -> float:
    started_s = time.process_time()
    work()
    return 1000 * (time.process_time() - started_s)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    speckle = np.clip(70 * np.random.default_rng(1).gamma(2.5, 1 / 2.5, (932, 1920)), 0, 255).astype(np.uint8)
    theirs, ours = cv2.CascadeClassifier(MODEL), _core.HaarCascade.load(MODEL)
    for name, picture in (("speckle", speckle), ("smoothed speckle", cv2.GaussianBlur(speckle, (0, 0), 2))):
        for threads in (1, 2):
            cv2.setNumThreads(threads)
            pairs = [
                (
                    cpu_ms(lambda picture=picture: theirs.detectMultiScale(picture, 1.1, 3, 0, (24, 24))),
                    cpu_ms(lambda picture=picture, threads=threads: _core.detect_objects(ours, picture, None, CONFIG, threads)),
                )
                for _ in range(rounds)
            ]
            cv_ms, our_ms = (statistics.median(times) for times in zip(*pairs, strict=True))
            ratio = statistics.median(our / cv for cv, our in pairs)
            print(f"{name}, {threads} threads: cv2 {cv_ms:.0f} ms, here {our_ms:.0f} ms, ratio {ratio:.2f}", flush=True)


if __name__ == "__main__":
    main()
