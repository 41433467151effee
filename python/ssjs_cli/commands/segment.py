"""ssjs-cli segment: sonar images to masks, regions and centroids."""

from typing import Any

import click

from ssjs_cli.options import common_options, path_of, pixel_size_option
from ssjs_cli.segment_options import segmentation_options, settings_request
from ssjs_cli.session import Session


@click.command()
@click.argument("images", nargs=-1, required=True)
@click.option("--method", default=None, metavar="improved-otsu|otsu|local|iterative|max-entropy", help="Threshold method.")
@segmentation_options
@pixel_size_option
@click.option(
    "--nadir", default=None, metavar="left|middle|right|COLUMN", help="Where the sonar passed; across-track distances start there."
)
@click.option("--objects", default=None, metavar="regions|shadows", help="Objects are near regions, or highlights with shadows.")
@click.option("--altitude-m", type=float, default=None, help="Of the sonar above the seabed, for heights from shadows.")
@click.option("--keep-intermediates", is_flag=True, help="Also write what every stage of the chain hands on.")
@click.option("--jobs", type=click.IntRange(1), default=None, help="Worker processes (default: one a core).")
@click.option("--no-report", is_flag=True, help="Leave out report.html and contact_sheet.png.")
@common_options(out_help="Result directory (default runs/<first folder or image>-segmentation).")
@click.pass_obj
def segment(session: Session, /, images: tuple[str, ...], **options: Any) -> int:
    """Segment sonar images: files, folders or patterns. Masks, overlays, regions, objects, a contact sheet and a page.

    \b
    ssjs-cli segment survey/ --preset sss-high --jobs 4
    ssjs-cli segment 'dives/**/*.png' --padding 0 --pixel-size-m 0.05,0.02
    ssjs-cli segment line07.png --objects shadows --nadir middle --altitude-m 12 --pixel-size-m 0.1,0.05
    """
    from ssjs_cli.segmentation.answer import answer_segmentation
    from ssjs_cli.segmentation.run import SegmentationRequest, segment_images

    request = SegmentationRequest(
        images,
        settings_request(options),
        valid_mask=path_of(options["valid_mask"]),
        jobs=options["jobs"],
        keep_steps=options["keep_intermediates"],
        with_report=not options["no_report"],
        out=path_of(options["out"]),
        force=options["force"],
    )
    return answer_segmentation(segment_images(request, session), session)
