"""OpenCV 4 reads our models and finds the same windows; its own models find the same windows here."""

from pathlib import Path

import numpy as np
import pytest

from ssjs_cli import _core

cv2 = pytest.importorskip("cv2")
if not hasattr(cv2, "CascadeClassifier"):
    pytest.skip("this OpenCV has no CascadeClassifier", allow_module_level=True)

END_OF_STAGE = "</weakClassifiers></_>"


def ours(model: _core.HaarCascade, image: np.ndarray, **config: object) -> set[tuple[int, ...]]:
    found = _core.detect_objects(model, image, None, {"min_neighbours": 0, **config})
    return {tuple(int(value) for value in row[:4]) for row in found.tolist()}


def theirs(path: Path, image: np.ndarray, **options: object) -> set[tuple[int, ...]]:
    classifier = cv2.CascadeClassifier(str(path))
    assert not classifier.empty()
    return {tuple(int(value) for value in box) for box in classifier.detectMultiScale(image, scaleFactor=1.1, minNeighbors=0, **options)}


def pictures(count: int) -> list[np.ndarray]:
    """Smooth patches and speckle, which early layers of any model pass now and then."""
    rng = np.random.default_rng(11)
    made = []
    for _ in range(count):
        blocks = rng.integers(20, 235, (18, 24), dtype=np.uint8)
        smooth = cv2.resize(blocks, (240, 180), interpolation=cv2.INTER_CUBIC).astype(np.float64)
        made.append(np.clip(smooth * rng.gamma(9.0, 1.0 / 9.0, smooth.shape), 0, 255).astype(np.uint8))
    return made


def test_opencv_finds_the_same_windows_at_every_scale(trained: Path, scenes: object) -> None:
    model = _core.HaarCascade.load(str(trained / "cascade.json"))
    total = 0
    for name in sorted(scenes.boxes):
        image = cv2.imread(str(scenes.positives / name), cv2.IMREAD_GRAYSCALE)
        found = ours(model, image)
        assert found == theirs(trained / "cascade.xml", image), name
        total += len(found)
    assert total > 100


def test_opencv_finds_the_same_windows_at_scale_one(trained: Path, scenes: object) -> None:
    model = _core.HaarCascade.load(str(trained / "cascade.json"))
    size = model.window
    limits = {"max_width_px": size[0], "max_height_px": size[1]}
    total = 0
    for name in sorted(scenes.boxes):
        image = cv2.imread(str(scenes.positives / name), cv2.IMREAD_GRAYSCALE)
        found = ours(model, image, **limits)
        assert found == theirs(trained / "cascade.xml", image, maxSize=size), name
        total += len(found)
    assert total > 0


def test_opencvs_own_face_model_finds_the_same_windows_here() -> None:
    path = Path(cv2.data.haarcascades) / "haarcascade_frontalface_default.xml"
    model = _core.HaarCascade.load(str(path))
    assert len(model.stages) == 25
    for image in pictures(5):
        assert ours(model, image) == theirs(path, image)


def test_the_first_layers_of_opencvs_face_model_find_the_same_windows_here(tmp_path: Path) -> None:
    """The whole model finds no face in noise; cut off after two layers it finds many windows."""
    path = Path(cv2.data.haarcascades) / "haarcascade_frontalface_default.xml"
    text = path.read_text()
    first, second, *_ = text.split(END_OF_STAGE)
    rest = text[text.index("</stages>") :]
    shortened = tmp_path / "first_layers.xml"
    shortened.write_text((first + END_OF_STAGE + second + END_OF_STAGE + rest).replace("<stageNum>25</stageNum>", "<stageNum>2</stageNum>"))
    model = _core.HaarCascade.load(str(shortened))
    assert len(model.stages) == 2
    total = 0
    for image in pictures(5):
        found = ours(model, image)
        assert found == theirs(shortened, image)
        total += len(found)
    assert total > 100


def test_xml_comes_back_as_it_was(trained: Path) -> None:
    model = _core.HaarCascade.load(str(trained / "cascade.json"))
    again = _core.HaarCascade.from_opencv_xml(model.to_opencv_xml())
    assert again.features() == model.features()
    assert again.stages == model.stages
    assert again.to_opencv_xml() == model.to_opencv_xml()
