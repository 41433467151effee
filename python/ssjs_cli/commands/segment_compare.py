"""ssjs-cli segment-compare: the five threshold methods on the same images."""

from typing import Any

import click

from ssjs_cli.options import common_options, path_of
from ssjs_cli.segment_options import segmentation_options, settings_request
from ssjs_cli.session import Session


@click.command("segment-compare")
@click.argument("images", nargs=-1, required=True)
@click.option("--masks", type=click.Path(), default=None, metavar="DIR", help="Truth: a mask of the same name for each image.")
@click.option("--one-object", is_flag=True, help="What a mask shows is one object, connected or not.")
@click.option("--boxes", type=click.Path(), default=None, metavar="FILE|DIR", help="Truth: a CSV table of boxes, or an XML file an image.")
@click.option("--no-objects", is_flag=True, help="Truth: the images are known to hold no object.")
@segmentation_options
@click.option("--repeat", "repeats", type=click.IntRange(1), default=3, show_default=True, help="Rounds of timing; medians are told.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Worker processes; for times to quote, one.")
@click.option("--no-report", is_flag=True, help="Leave out report.html.")
@common_options(out_help="Result directory (default runs/<first folder or image>-segment-comparison).")
@click.pass_obj
def segment_compare(session: Session, /, images: tuple[str, ...], **options: Any) -> int:
    """Improved Otsu, Otsu, local, iterative and maximum entropy on the same images: thresholds, times, and errors against a truth.

    \b
    ssjs-cli segment-compare tiles/images --masks tiles/masks
    ssjs-cli segment-compare frames/ --boxes frames.csv --padding 0
    """
    from ssjs_cli.segmentation.answer import answer_comparison
    from ssjs_cli.segmentation.comparison import ComparisonRequest, compare_methods
    from ssjs_cli.segmentation.truth import TruthSource

    request = ComparisonRequest(
        images,
        settings_request(options),
        TruthSource(path_of(options["masks"]), path_of(options["boxes"]), options["no_objects"], options["one_object"]),
        valid_mask=path_of(options["valid_mask"]),
        repeats=options["repeats"],
        jobs=options["jobs"],
        with_report=not options["no_report"],
        out=path_of(options["out"]),
        force=options["force"],
    )
    return answer_comparison(compare_methods(request, session), session)
