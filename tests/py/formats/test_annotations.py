import json
from pathlib import Path

import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.annotations.annotation_source import Annotations, BoxFinder, read_annotations
from ssjs_cli.formats.annotations.boxes import Box, LabelledBox

#: One picture of 100 x 50 px with the box left 10, top 20, width 30, height 15.
WIDTH_PX, HEIGHT_PX, BOX = 100, 50, (10, 20, 30, 15)
VOC = (
    "<annotation><filename>a.png</filename><object><name>wreck</name><bndbox>"
    "<xmin>11</xmin><ymin>21</ymin><xmax>40</xmax><ymax>35</ymax></bndbox></object></annotation>"
)


def boxes_of(annotations: Annotations, image: str) -> list[Box]:
    found = BoxFinder(annotations).find(Path(image))
    assert found is not None
    return [box.in_pixels(WIDTH_PX, HEIGHT_PX) for box in found]


def written(tmp_path: Path, name: str, text: str) -> Path:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def coco(**changes: object) -> str:
    document = {
        "images": [{"id": 7, "file_name": "a.png"}, {"id": 8, "file_name": "empty.png"}],
        "annotations": [{"image_id": 7, "category_id": 2, "bbox": [10, 20, 30, 15]}],
        "categories": [{"id": 2, "name": "wreck"}, {"id": 3, "name": "mine"}],
    }
    return json.dumps({**document, **changes})


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("info.dat", "a.png 1 10 20 30 15\n"),
        ("boxes.csv", "image,x_px,y_px,width_px,height_px,label\na.png,10,20,30,15,wreck\n"),
        ("a.xml", VOC),
        ("coco.json", coco()),
    ],
)
def test_every_form_says_the_same_box(tmp_path: Path, name: str, text: str) -> None:
    assert boxes_of(read_annotations(written(tmp_path, name, text)), "/data/a.png") == [BOX]


def test_yolo_and_voc_folders_say_the_same_box(tmp_path: Path) -> None:
    # centre (10 + 15, 20 + 7.5), as parts of 100 x 50
    written(tmp_path, "yolo/a.txt", "0 0.25 0.55 0.3 0.3\n")
    written(tmp_path, "yolo/classes.txt", "wreck\nmine\n")
    written(tmp_path, "voc/a.xml", VOC)
    for folder in ("yolo", "voc"):
        annotations = read_annotations(tmp_path / folder)
        assert boxes_of(annotations, "/data/a.png") == [BOX]
        assert annotations.labels() == ["wreck"]
        assert BoxFinder(annotations).find(Path("/data/b.png")) is None


def test_voc_counts_from_one_and_to_the_last_pixel_inside(tmp_path: Path) -> None:
    whole = VOC.replace("11", "1").replace("21", "1").replace("40", "100").replace("35", "50")
    assert boxes_of(read_annotations(written(tmp_path, "a.xml", whole)), "a.png") == [(0, 0, WIDTH_PX, HEIGHT_PX)]


@pytest.mark.parametrize(
    ("name", "text", "where"),
    [
        ("info.dat", "b.png 0\na.png 2 10 20 30 15\n", "info.dat:2"),
        ("info.dat", "a.png 1 10 20 30 x\n", "info.dat:1"),
        ("info.dat", "a.png 1 10 20 30 0\n", "info.dat:1"),
        ("info.dat", "a.png\n", "info.dat:1"),
        ("info.dat", '"a.png 1 10 20 30 15\n', "info.dat:1"),
        ("boxes.csv", "image,x_px,y_px,width_px\n", "boxes.csv:1"),
        ("boxes.csv", "image,x_px,y_px,width_px,height_px\na.png,1,2,3,4\na.png,10,20,30\n", "boxes.csv:3"),
        ("boxes.csv", "image,x_px,y_px,width_px,height_px\na.png,10,20,nan,15\n", "boxes.csv:2"),
        ("boxes.csv", "image,x_px,y_px,width_px,height_px\na.png,10,20,1e300,15\n", "boxes.csv:2"),
        ("a.xml", VOC[:-20], "a.xml:1"),
        ("a.xml", "<html/>", "a.xml"),
        ("a.xml", VOC.replace("<xmax>40</xmax>", ""), "a.xml: object 1"),
        ("a.xml", VOC.replace("<xmax>40", "<xmax>4"), "a.xml: object 1"),
        ("coco.json", coco()[:-9], "coco.json:1"),
        ("coco.json", "[]", "coco.json"),
        ("coco.json", coco(annotations=[{"image_id": 7, "bbox": [1, 2, 3]}]), "coco.json: annotations[0]"),
        ("coco.json", coco(annotations=[{"image_id": 99, "bbox": [1, 2, 3, 4]}]), "coco.json: annotations[0]"),
        ("coco.json", coco(annotations=[{"image_id": [7], "bbox": [1, 2, 3, 4]}]), "coco.json: annotations[0]"),
        ("coco.json", coco(annotations=[{"image_id": 7, "bbox": [1, 2, -3, 4]}]), "coco.json: annotations[0]"),
        ("coco.json", coco(images=[{"id": 7}]), "coco.json: images[0]"),
        ("coco.json", coco(images={}), "coco.json"),
        ("boxes.jpg", "", "boxes.jpg"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, name: str, text: str, where: str) -> None:
    with pytest.raises(UserError) as raised:
        read_annotations(written(tmp_path, name, text))
    assert str(raised.value).startswith(str(tmp_path / where))


@pytest.mark.parametrize(
    "line", ["0 0.5 0.5 0.2", "wreck 0.5 0.5 0.2 0.2", "0 0.5 0.5 1.2 0.2", "0 50 50 20 20", "0 0.5 nan 0.2 0.2", "0 0.5 0.5 0 0.2"]
)
def test_a_yolo_file_that_cannot_be_read_is_named_and_the_others_are_used(tmp_path: Path, line: str) -> None:
    written(tmp_path, "a.txt", "0 0.25 0.55 0.3 0.3\n")
    written(tmp_path, "b.txt", f"0 0.25 0.55 0.3 0.3\n{line}\n")
    annotations = read_annotations(tmp_path)
    assert list(annotations.images) == ["a.txt"]
    assert [name for name, _ in annotations.problems] == ["b.txt"]
    assert str(tmp_path / "b.txt:2") in annotations.problems[0][1]


def test_entities_are_not_expanded(tmp_path: Path) -> None:
    bomb = '<!DOCTYPE annotation [<!ENTITY a "40"><!ENTITY b "&a;&a;">]>' + VOC.replace("<xmax>40", "<xmax>&b;")
    with pytest.raises(UserError, match="DOCTYPE"):
        read_annotations(written(tmp_path, "a.xml", bomb))
    outside = f'<!DOCTYPE annotation [<!ENTITY a SYSTEM "file://{tmp_path}/secret">]>' + VOC.replace("wreck", "&a;")
    with pytest.raises(UserError, match="DOCTYPE"):
        read_annotations(written(tmp_path, "b.xml", outside))


def test_boxes_outside_the_picture_are_refused_and_rounding_is_not() -> None:
    inside = LabelledBox(-1, 0, 102, 50, "info.dat:3")
    assert inside.in_pixels(WIDTH_PX, HEIGHT_PX) == (0, 0, WIDTH_PX, HEIGHT_PX)
    for box in (
        LabelledBox(90, 10, 20, 10, "info.dat:3"),
        LabelledBox(-30, 10, 20, 10, "info.dat:3"),
        LabelledBox(500, 500, 9, 9, "info.dat:3"),
    ):
        with pytest.raises(UserError, match=r"info\.dat:3: the box .* leaves the picture of 100 x 50 px"):
            box.in_pixels(WIDTH_PX, HEIGHT_PX)


def test_only_the_asked_class_and_a_known_one(tmp_path: Path) -> None:
    annotations = read_annotations(written(tmp_path, "coco.json", coco()))
    assert annotations.of_label("wreck").images == annotations.images
    with pytest.raises(UserError, match="no box has the label 'mine'; its labels are 'wreck'"):
        annotations.of_label("mine")


def test_an_image_is_found_by_the_longest_common_end(tmp_path: Path) -> None:
    annotations = read_annotations(written(tmp_path, "info.dat", "x/a.png 1 1 2 3 4\ny/a.png 1 5 6 7 8\n"))
    assert boxes_of(annotations, "/data/y/a.png") == [(5, 6, 7, 8)]
    with pytest.raises(UserError, match="may mean"):
        BoxFinder(annotations).find(Path("/data/z/a.png"))
    assert list(BoxFinder(annotations).unfound([Path("/data/y/b.png")])) == ["x/a.png", "y/a.png"]


def test_paths_with_blanks_stand_in_quotes(tmp_path: Path) -> None:
    annotations = read_annotations(written(tmp_path, "info.dat", '"my tiles/a.png" 1 10 20 30 15\n'))
    assert boxes_of(annotations, "/data/my tiles/a.png") == [BOX]
