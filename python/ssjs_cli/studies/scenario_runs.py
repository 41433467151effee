"""Runs of one scenario under several seeds: what `consistency` and `sweep` are made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ssjs_cli.config import MAX_SEED, Scalar, Settings
from ssjs_cli.errors import UserError
from ssjs_cli.formats.mission import Mission
from ssjs_cli.mission_run import RunRequest, model_digests, path_name, resolve_settings
from ssjs_cli.progress import working
from ssjs_cli.simulation import Scenario, read_scenario, simulate_mission
from ssjs_cli.studies.carry_out import PlannedRun
from ssjs_cli.studies.executor import Executor
from ssjs_cli.studies.process_pool import ProcessPool
from ssjs_cli.studies.single_run import Detail, RunTask, core_identity


@dataclass(frozen=True)
class StudyRequest:
    """What the commands share. workers: None means one a core; scheduler: of a Dask cluster, instead of workers here; time_limit_s: of
    each run."""

    scenario: str
    runs: int
    methods: Sequence[str]
    association: str | None = None
    config_path: Path | None = None
    assignments: Sequence[str] = ()
    seed: int | None = None
    out: Path | None = None
    force: bool = False
    workers: int | None = None
    scheduler: str | None = None
    time_limit_s: float | None = None

    def executor(self) -> Executor:
        return executor_of(self.workers, self.scheduler, self.time_limit_s)

    def folder(self, scenario: Scenario, kind: str) -> Path:
        return self.out if self.out is not None else Path("runs") / f"{path_name(scenario.name)}-{kind}"


def executor_of(workers: int | None, scheduler: str | None, time_limit_s: float | None = None) -> Executor:
    """Workers here, one a core where their number is not said, or those of a Dask scheduler."""
    if workers is not None and scheduler is not None:
        raise UserError("--jobs and --scheduler: the workers of a scheduler are counted there; give one of the two")
    if scheduler is not None:
        from ssjs_cli.studies.dask_pool import DaskPool

        return DaskPool(scheduler)
    return ProcessPool(workers if workers is not None else cores(), time_limit_s=time_limit_s)


def cores() -> int:
    """Those that this process may use."""
    import os

    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class PlannedScenario:
    """scenario: with the first seed; mission: its simulation, for what does not depend on the seed."""

    scenario: Scenario
    mission: Mission
    seeds: list[int]

    def settings(self, request: StudyRequest, method: str | None, changes: Mapping[str, Scalar], source: str = "") -> Settings:
        """changes, from `source`, are laid over all that the user said. method None: the one that the settings name."""
        where = Path(f"scenario {self.scenario.name}")
        run = RunRequest(
            where,
            seed=self.scenario.seed,
            method=method,
            association=request.association,
            config_path=request.config_path,
            assignments=request.assignments,
        )
        settings, _ = resolve_settings(run, where, self.mission)
        return settings.replaced(changes, source) if changes else settings

    def run(self, settings: Settings, seed: int, detail: Detail, time_limit_s: float | None) -> PlannedRun:
        core = core_identity()
        values = dict(settings.values)
        models = model_digests(settings)
        identity = {"detail": detail, **core, "scenario": self.scenario.identity, "seed": seed, "settings": values, "models": models}
        return PlannedRun(identity, RunTask(replace(self.scenario, seed=seed), values, seed, core["version"], detail, time_limit_s))


def plan_scenario(request: StudyRequest) -> PlannedScenario:
    scenario = read_scenario(request.scenario, request.seed)
    last = scenario.seed + request.runs - 1
    if last > MAX_SEED:
        raise UserError(f"--seed {scenario.seed}: leaves no room for {request.runs} seeds below 2^64; give a smaller one")
    with working("simulating"):
        mission = simulate_mission(scenario)
    return PlannedScenario(scenario, mission, list(range(scenario.seed, last + 1)))


def definition_of(kind: str, request: StudyRequest, plan: PlannedScenario, **more: Any) -> dict[str, Any]:
    from ssjs_cli.studies.study_folder import key_of

    return {
        "study": kind,
        "scenario": plan.scenario.name,
        "methods": list(request.methods),
        "runs": request.runs,
        "seed": plan.scenario.seed,
        **more,
        **core_identity(),
        "scenario digest": key_of(plan.scenario.identity),
    }
