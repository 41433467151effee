"""What a finished consistency study or sweep says on the terminal."""

from ssjs_cli.exit_codes import DONE, PARTLY_DONE
from ssjs_cli.session import Session
from ssjs_cli.studies import monte_carlo
from ssjs_cli.studies import sweep as sweeping
from ssjs_cli.studies.monte_carlo import ConsistencyStudy
from ssjs_cli.studies.sweep import Sweep
from ssjs_cli.studies.tables import Column, terminal_table

CONSISTENCY_COLUMNS: tuple[Column, ...] = (
    ("method", "method", ""),
    ("runs", "runs", "d"),
    ("nees_mean", "NEES (3)", ".3f"),
    ("nees_band_low", "band from", ".2f"),
    ("nees_band_high", "to", ".2f"),
    ("nees_inside_fraction", "inside", ".1%"),
    ("nees_online_mean", "online", ".3f"),
    ("nees_online_inside_fraction", "inside", ".1%"),
    ("nees_joint_per_dof", "joint/dof", ".3f"),
    ("nees_joint_band_low", "band from", ".3f"),
    ("nees_joint_band_high", "to", ".3f"),
    ("nees_map_mean", "map (2)", ".2f"),
    ("nees_position_per_dof", "position/dof", ".2f"),
    ("inside_3_sigma_fraction", "within 3 sigma", ".1%"),
    ("nis_mean", "NIS/dof", ".4f"),
    ("nis_band_low", "band from", ".4f"),
    ("nis_band_high", "to", ".4f"),
    ("trajectory_rmse_m", "RMSE m", ".3f"),
    ("map_error_mean_m", "map m", ".3f"),
    ("wrong_pairs", "wrong pairs", ".2f"),
    ("reason", "why not", ""),
)
SWEEP_COLUMNS: tuple[Column, ...] = (
    ("method", "method", ""),
    ("submap_size", "submap size", "g"),
    ("fusion_threshold", "threshold", ".2f"),
    ("runs", "runs", "d"),
    ("time_total_s", "total s", ".3f"),
    ("time_local_s", "local s", ".3f"),
    ("time_association_s", "assoc. s", ".3f"),
    ("time_global_s", "global s", ".3f"),
    ("loop_candidates", "pairs tested", ".0f"),
    ("fusions", "fusions", ".0f"),
    ("live_maps", "live maps", ".0f"),
    ("wrong_pairs", "wrong pairs", ".1f"),
    ("map_error_mean_m", "map mean m", ".3f"),
    ("trajectory_rmse_m", "RMSE m", ".3f"),
    ("nees_joint_per_dof", "joint/dof", ".2f"),
    ("nees_position_per_dof", "position/dof", ".2f"),
    ("inside_3_sigma_fraction", "within 3 sigma", ".1%"),
    ("reason", "why not", ""),
)


def answer_consistency(study: ConsistencyStudy, session: Session) -> int:
    for text in study.lost:
        session.message(f"lost: {text}")
    table = terminal_table(f"{study.scenario.name}: {len(study.seeds)} seeds from {study.seeds[0]}", CONSISTENCY_COLUMNS, study.rows)
    files = f"results     {study.folder / monte_carlo.CONSISTENCY_FILE}\nreport      {study.folder / monte_carlo.REPORT_FILE}"
    session.answer(study.document, f"{table}\n\n{files}")
    return PARTLY_DONE if study.lost else DONE


def answer_sweep(sweep: Sweep, session: Session) -> int:
    for text in sweep.lost:
        session.message(f"lost: {text}")
    table = terminal_table(f"{sweep.scenario.name}: {len(sweep.seeds)} seeds from {sweep.seeds[0]}", SWEEP_COLUMNS, sweep.cells)
    files = f"results     {sweep.folder / sweeping.SWEEP_FILE}\nreport      {sweep.folder / sweeping.REPORT_FILE}"
    session.answer(sweep.document, f"{table}\n\n{files}")
    return PARTLY_DONE if sweep.lost else DONE
