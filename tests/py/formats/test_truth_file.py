from collections.abc import Callable
from pathlib import Path

import pytest

from ssjs_cli.errors import UserError
from ssjs_cli.formats.truth_file import read_box_table, read_box_xml


def refused(read: Callable[[Path], object], path: Path, text: str) -> str:
    path.write_text(text)
    with pytest.raises(UserError) as caught:
        read(path)
    assert str(caught.value).startswith(str(path))
    return str(caught.value)


def test_boxes_of_a_table(tmp_path: Path) -> None:
    path = tmp_path / "boxes.csv"
    path.write_text("image,score,x_px,y_px,width_px,height_px\na.png,1,2,3,4,5\n\nb.png,1,6,7,8,9\na.png,1,1.6,0,2,2\n")
    assert read_box_table(path) == {"a.png": [(2, 3, 4, 5), (2, 0, 2, 2)], "b.png": [(6, 7, 8, 9)]}


def test_faults_of_a_table_name_the_line(tmp_path: Path) -> None:
    path = tmp_path / "boxes.csv"
    header = "image,x_px,y_px,width_px,height_px\n"
    assert f"{path}:1: has no column 'height_px'" in refused(read_box_table, path, "image,x_px,y_px,width_px\n")
    assert f"{path}:3: has 3 fields where the header has 5" in refused(read_box_table, path, header + "a,1,2,3,4\nb,1,2\n")
    assert f"{path}:2: 'wide' is no number" in refused(read_box_table, path, header + "a,1,2,wide,4\n")
    assert f"{path}:2: 'nan' is no number of pixels" in refused(read_box_table, path, header + "a,nan,2,3,4\n")
    assert f"{path}:2: has a width of 0" in refused(read_box_table, path, header + "a,1,2,0,4\n")


def test_boxes_of_both_forms_of_xml(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    path.write_text(
        "<annotation><object><name>tyre</name><bndbox><x>1</x><y>2</y><w>3</w><h>4</h></bndbox></object>"
        "<object><bndbox><xmin>10</xmin><ymin>20</ymin><xmax>15</xmax><ymax>27</ymax></bndbox></object></annotation>"
    )
    assert read_box_xml(path) == [(1, 2, 3, 4), (10, 20, 5, 7)]


def test_xml_with_declarations_is_not_expanded(tmp_path: Path) -> None:
    bomb = '<!DOCTYPE a [<!ENTITY b "ha"><!ENTITY c "&b;&b;&b;">]><a>&c;</a>'
    assert "is no plain list of boxes" in refused(read_box_xml, tmp_path / "a.xml", bomb)


def test_faults_of_xml_name_the_box(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    assert "is not valid XML" in refused(read_box_xml, path, "<annotation>")
    assert "box 1: has neither x, y, w, h nor" in refused(read_box_xml, path, "<a><bndbox><x>1</x></bndbox></a>")
    assert "box 1: has a width of -5" in refused(
        read_box_xml, path, "<a><bndbox><xmin>9</xmin><ymin>0</ymin><xmax>4</xmax><ymax>3</ymax></bndbox></a>"
    )
