"""What a finished segmentation says on the terminal."""

from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.segmentation.result_files import OBJECTS_FILE, PAGE_FILE, REGIONS_FILE
from ssjs_cli.segmentation.run import FinishedSegmentation
from ssjs_cli.session import Session


def answer_segmentation(finished: FinishedSegmentation, session: Session) -> int:
    for name, reason in finished.failures:
        session.message(f"lost: {reason}" if name in reason else f"lost: {name}: {reason}")
    totals = finished.document["totals"]
    lines = [f"{totals['images']} images, {totals['regions']} regions, {totals['objects']} objects ({finished.document['method']})"]
    if finished.document["method"] == "improved-otsu":
        lines.append(f"  second pass in {totals['second_pass_fired']} images")
    if totals["without_threshold"]:
        lines.append(f"  {totals['without_threshold']} images have no threshold")
    if totals["failed"]:
        lines.append(f"  {totals['failed']} images could not be used")
    names = [name for name in (REGIONS_FILE, OBJECTS_FILE, PAGE_FILE) if (finished.directory / name).is_file()]
    lines += [f"{name.split('.')[0]:<11} {finished.directory / name}" for name in names]
    session.answer({"directory": str(finished.directory), **finished.document}, "\n".join(lines))
    return PARTLY_DONE if finished.failures else DONE
