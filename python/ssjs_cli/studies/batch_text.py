"""What a finished batch says on the terminal."""

from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.session import Session
from ssjs_cli.studies import batch
from ssjs_cli.studies.batch import Season
from ssjs_cli.studies.season_output import REPORT_FILE
from ssjs_cli.studies.tables import Column, terminal_table

MAX_SHOWN = 20
COLUMNS: tuple[Column, ...] = (
    ("mission", "mission", ""),
    ("outlier_score", "stands out", ".1f"),
    ("stands_out_by", "by", ""),
    ("landmarks", "landmarks", "d"),
    ("loop_closures", "loops", "d"),
    ("nis_mean", "NIS/dof", ".3f"),
    ("trajectory_rmse_m", "RMSE m", ".3f"),
    ("time_total_s", "total s", ".2f"),
    ("reason", "why not", ""),
)


def answer_batch(season: Season, session: Session) -> int:
    for text in season.lost[:MAX_SHOWN]:
        session.message(f"lost: {text}")
    finished = sum(1 for row in season.rows if not row["reason"])
    title = f"{finished} of {len(season.rows)} missions finished"
    if len(season.rows) > MAX_SHOWN:
        title += f"; the first {MAX_SHOWN}, all in {season.folder / batch.SEASON_FILE}"
    table = terminal_table(title, COLUMNS, season.rows[:MAX_SHOWN])
    files = f"results     {season.folder / batch.SEASON_FILE}\nreport      {season.folder / REPORT_FILE}"
    session.answer(season.document, f"{table}\n\n{files}")
    return PARTLY_DONE if season.lost else DONE
