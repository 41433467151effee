"""The sections that only the report of an underwater mission has. What has no data is left out."""

from dataclasses import dataclass, field

from ssjs_cli.report.contact_cards import ContactSheet, contact_sheet
from ssjs_cli.report.coverage_figure import coverage_figure
from ssjs_cli.report.depth_figures import depth_profile, side_view
from ssjs_cli.report.error_figures import Drawing
from ssjs_cli.report.map_figure import MapAxes, SubmapColours
from ssjs_cli.report.page_parts import Plot
from ssjs_cli.report.result_files import RunFiles
from ssjs_cli.report.sensor_sheet import sensor_sheet
from ssjs_cli.report.sheet import Sheet
from ssjs_cli.report.space_figures import space_view, top_view
from ssjs_cli.report.uncertainty_figures import closing_sheet, uncertainty
from ssjs_cli.report.waterfall_section import DrawnLine, WaterfallSection, stretch, waterfall

PANEL_HEIGHT_PX = 420


@dataclass
class SurveySections:
    """sonar: the picture of the first of the four panels; views: the other three, as many as there are."""

    sonar: DrawnLine | None = None
    views: list[Plot] = field(default_factory=list)
    contacts: ContactSheet | None = None
    waterfall: WaterfallSection | None = None
    coverage: Plot | None = None
    depth: Plot | None = None
    uncertainty: Plot | None = None
    closings: Sheet | None = None
    sensors: Sheet | None = None

    @property
    def plots(self) -> list[Plot]:
        return [*self.views, *(plot for plot in (self.coverage, self.depth, self.uncertainty) if plot is not None)]


def survey_sections(files: RunFiles, axes: MapAxes, colours: SubmapColours) -> SurveySections | None:
    """None for a vehicle in the plane."""
    if files.trajectory is None or files.trajectory.depth is None:
        return None
    views = [
        _plot("space-view", "Track and landmarks in space", space_view(files, axes, colours, PANEL_HEIGHT_PX)),
        _plot("top-view", "From above: submaps, landmarks, 95 % ellipses", top_view(files, axes, colours, PANEL_HEIGHT_PX)),
        _plot("side-view", "From the side", side_view(files, axes, colours, PANEL_HEIGHT_PX)),
    ]
    return SurveySections(
        sonar=stretch(files.survey),
        views=[plot for plot in views if plot is not None],
        contacts=contact_sheet(files.survey) if files.shows_contacts else None,
        waterfall=waterfall(files.survey),
        coverage=_plot("coverage", "Coverage", coverage_figure(files, axes)),
        depth=_plot("depth-profile", "Depth of vehicle and seabed", depth_profile(files)),
        uncertainty=_plot("uncertainty", "Position σ before and after each loop closure", uncertainty(files)),
        closings=closing_sheet(files),
        sensors=sensor_sheet(files.summary),
    )


def _plot(div_id: str, heading: str, drawing: Drawing | None) -> Plot | None:
    return None if drawing is None else Plot(div_id, heading, drawing.figure, drawing.notes)
