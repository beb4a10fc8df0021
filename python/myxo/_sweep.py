"""Sweeps: many runs over any executor, each written as soon as it is done."""

from __future__ import annotations

import concurrent.futures
import hashlib
import inspect
import io
import json
import multiprocessing
import os
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _myxo, _runs
from ._points import Point, grid, sample
from ._scene import Scene

if TYPE_CHECKING:
    import pandas

# A row, and fields as the bytes of a file.
_Result = tuple[dict[str, Any], bytes | None]
# A run whose process dies is begun again alone so often.
ATTEMPTS = 3
# An executor without futures of the standard library is asked this often, seconds.
ASKS_EVERY = 0.2
# A column of the table has the name of its parameter; these stand before and after.
FIRST = ("run", "seed")
LAST = ("step", "state_hash", "seconds", "device", "error")


def sweep(
    points: str | os.PathLike[str] | Mapping[str, Iterable[Any]] | Iterable[Point],
    run: _runs.Run | None = None,
    *,
    out: str | os.PathLike[str],
    scene: str | os.PathLike[str] | Mapping[str, Any] | Scene = "torus",
    steps: int = 400,
    seeds: int | Iterable[int] = 1,
    preset: str | None = None,
    settings: Mapping[str, Any] | None = None,
    fields: Sequence[str] = (),
    executor: Any = None,
    workers: int | None = None,
    device: str | int | None = None,
    shard: tuple[int, int] | None = None,
    progress: bool = True,
) -> pandas.DataFrame:
    """Runs a scene at many points of its parameters, and returns a table with a row for each run.

        table = myxo.sweep(
            {"physarum.sensor_angle": [15, 30, 45], "physarum.rotation_angle": [15, 30, 45]},
            scene="plane", steps=400, seeds=3, out="angles",
        )

    A run that is done is written at once; asked for again, it is not run again. So a sweep that was ended goes on where it was, and
    one with more points or seeds runs only those.

    Parameters
    ----------
    points
        A grid: values for each parameter. Or points: dictionaries with a value for each parameter (`myxo.grid`, `myxo.sample`). Or
        the path of a study file, which has all of this and the next.
    run
        What a run does, in place of `sim.step(steps)`: a function of the simulation and the point, which returns numbers and texts for
        the row, and arrays for `fields`. It must be found by name in a module, as executors need it.
    out
        The folder: `table.parquet` and `table.csv`, `runs/` with a row for each run, `fields/` with arrays.
    scene, steps, preset, settings
        As for `Simulation`; `settings` lie under the point's values.
    seeds
        So many from 0 on, or a list.
    fields
        Arrays of each run that are kept as NPZ: `trail`, `particles`, `deposits`, `texel_area`, ...
    executor
        Anything with the `submit` of `concurrent.futures.Executor`, such as Dask's `client.get_executor()`, mpi4py's `MPIPoolExecutor` or
        an executor of submitit. By default, processes on this machine.
    workers
        The number of these processes; by default as many as there are processors, or one if a `device` is chosen. On a graphics card,
        which runs one thing at a time, 1 is best.
    device
        As for `Simulation`.
    shard
        `(i, n)`: only each n-th run from the i-th on, counted from 0, for job arrays that share the folder.
    progress
        Shows how far it is.

    Returns
    -------
    pandas.DataFrame
        Columns `run` (number of the point), `seed`, each parameter, measures of the network, what `run` returned, `step`, `state_hash`,
        `seconds`, `device` and `error` (None where all went well).

    Raises
    ------
    ValueError
        If the folder holds another study.
    RuntimeError
        If another sweep writes into the folder.
    """
    library = _pandas()
    if isinstance(points, (str, os.PathLike)):
        study = read_study(points)
    else:
        study = {"points": points, "scene": scene, "steps": steps, "seeds": seeds, "preset": preset, "settings": settings}
    jobs = _jobs(study, run, tuple(fields), device)
    folder = Path(out)
    _claim(folder, study, run)
    number, of = shard or (0, 1)
    if not 0 <= number < of:
        raise ValueError(f"shard ({number}, {of}): the first is from 0 to below the second")
    own = [job for job in jobs if job["index"] % of == number]
    with _Lock(folder / f".lock-{number}-of-{of}"):
        missing = [job for job in own if not _row_file(folder, job).exists()]
        done = len(own) - len(missing)
        if missing:
            bar = _Progress(len(own), done) if progress else None
            try:
                for job, (row, packed) in _results(missing, executor, workers, device, progress):
                    _keep(folder, job, row, packed)
                    if bar:
                        bar.step(row["error"])
            finally:
                if bar:
                    bar.end()
                _write_table(folder, library)
        elif not (folder / "table.parquet").exists():
            _write_table(folder, library)
    wanted = {_row_file(folder, job).name for job in jobs}
    return _table(folder, library, wanted)


def read_study(path: str | os.PathLike[str]) -> dict[str, Any]:
    """A study file: `scene`, `steps`, `seeds`, `preset`, `[set]`, and `[grid]`, `[sample]` or `[[point]]`."""
    try:
        import tomllib
    except ModuleNotFoundError:
        import tomli as tomllib  # type: ignore[no-redef, import-not-found, unused-ignore]
    file = Path(path)
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    known = {"scene", "steps", "seeds", "preset", "set", "grid", "sample", "point"}
    for key in table:
        if key not in known:
            raise ValueError(f"{file}: there is no key `{key}` in a study: {', '.join(sorted(known))}")
    ways = [way for way in ("grid", "sample", "point") if way in table]
    if len(ways) != 1:
        raise ValueError(f"{file}: a study has one of [grid], [sample] and [[point]], not {len(ways)}")
    points: list[Point]
    if "grid" in table:
        points = grid(table["grid"])
    elif "point" in table:
        points = table["point"]
    else:
        of = table["sample"]
        points = sample(of["ranges"], of["count"], method=of.get("method", "latin"), seed=of.get("seed", 0))
    scene = table.get("scene", "torus")
    beside = file.parent / scene
    return {
        "points": points,
        "scene": str(beside) if beside.is_file() else scene,
        "steps": table.get("steps", 400),
        "seeds": table.get("seeds", 1),
        "preset": table.get("preset"),
        "settings": table.get("set"),
    }


def read_sweep(out: str | os.PathLike[str]) -> pandas.DataFrame:
    """The table of all runs that are done in the folder of a sweep."""
    return _table(Path(out), _pandas(), None)


def read_fields(out: str | os.PathLike[str], row: Mapping[str, Any]) -> dict[str, Any]:
    """The arrays of a run, given its row of the table."""
    import numpy as np

    with np.load(Path(out) / "fields" / f"{row['key']}.npz") as file:
        return {name: file[name] for name in file.files}


def to_dataset(table: pandas.DataFrame, *axes: str) -> Any:
    """The table of a grid as an `xarray.Dataset` with these parameters, and the seed if there are several, as dimensions."""
    dimensions = [*axes]
    if table["seed"].nunique() > 1 and "seed" not in dimensions:
        dimensions.append("seed")
    doubled = table.duplicated(dimensions)
    if doubled.any():
        raise ValueError(f"{doubled.sum()} runs have the same {', '.join(dimensions)}: name all parameters of the grid")
    return table.set_index(dimensions).to_xarray()


# What there is to do


def _jobs(study: Mapping[str, Any], run: _runs.Run | None, fields: tuple[str, ...], device: Any) -> list[dict[str, Any]]:
    points = study["points"]
    points = grid(points) if isinstance(points, Mapping) else [dict(point) for point in points]
    if not points:
        raise ValueError("there are no points: a sweep has one or more")
    seeds = study["seeds"]
    seeds = list(range(seeds)) if isinstance(seeds, int) else list(seeds)
    known = {row["key"] for row in _myxo.parameters()}
    settings = dict(study["settings"] or {})
    for key in {key for point in [*points, settings] for key in point}:
        if key not in known and key.split(".")[0] not in ("object", "food", "pulse"):
            raise KeyError(f"there is no parameter `{key}`: `myxo.parameters()` lists them all")
    fixed = _fixed(study, run)
    jobs: list[dict[str, Any]] = []
    for number, point in enumerate(points):
        for seed in seeds:
            key = _digest({**fixed, "point": point, "seed": seed, "fields": fields})
            jobs.append(
                {
                    "index": len(jobs),
                    "run": run,
                    "number": number,
                    "key": key,
                    "point": point,
                    "seed": int(seed),
                    "scene": study["scene"],
                    "steps": study["steps"],
                    "preset": study["preset"],
                    "settings": settings,
                    "fields": fields,
                    "device": device,
                }
            )
    return jobs


def _fixed(study: Mapping[str, Any], run: _runs.Run | None) -> dict[str, Any]:
    """What all runs of a study share, in a form that can be compared."""
    scene = study["scene"]
    if isinstance(scene, (str, os.PathLike)):
        path = Path(scene)
        name = path.name if path.is_file() else os.fspath(scene)
        scene_text = f"{name} {hashlib.sha256(path.read_bytes()).hexdigest()}" if path.is_file() else name
    else:
        made = scene if isinstance(scene, Scene) else Scene(scene)
        digest = hashlib.sha256(_plain(made.table()).encode())
        for mesh in made.meshes():
            for array in mesh[1] if mesh else ():
                digest.update(array.tobytes())
        scene_text = f"a dictionary {digest.hexdigest()}"
    return {
        "scene": scene_text,
        "steps": None if run else study["steps"],
        "preset": study["preset"],
        "settings": dict(study["settings"] or {}),
        "run": _name_of(run),
        "version": _myxo.version,
    }


def _name_of(run: _runs.Run | None) -> str | None:
    if run is None:
        return None
    name = f"{run.__module__}.{run.__qualname__}" if hasattr(run, "__qualname__") else repr(type(run))
    try:
        source = inspect.getsource(run)
    except (OSError, TypeError):
        return name
    return f"{name} {hashlib.sha256(source.encode()).hexdigest()[:12]}"


def _plain(value: Any, *, sort: bool = True) -> str:
    def simple(item: Any) -> Any:
        return item.tolist() if hasattr(item, "tolist") else str(item)

    return json.dumps(value, sort_keys=sort, default=simple)


def _digest(value: Any) -> str:
    return hashlib.sha256(_plain(value).encode()).hexdigest()[:16]


# Doing it


class _Died(Exception):
    """A process of a pool ended; these runs were under way."""

    def __init__(self, jobs: list[dict[str, Any]]) -> None:
        self.jobs = jobs


def _results(
    jobs: list[dict[str, Any]], executor: Any, workers: int | None, device: Any, says: bool
) -> Iterator[tuple[dict[str, Any], _Result]]:
    waiting = deque(jobs)
    if executor is not None:
        try:
            yield from _from(executor, waiting, None)
        except _Died:
            raise RuntimeError("a process of the executor died; what is done is kept: begin the sweep again with another one") from None
        return
    count = workers if workers is not None else _fitting(device)
    if count < 1:
        raise ValueError(f"workers is 1 or more, not {count}")
    count = min(count, len(jobs))
    if says:
        print(f"myxo: {len(jobs)} runs by {count} processes", file=sys.stderr)
    while waiting:
        suspects: list[dict[str, Any]] = []
        with _pool(count, count > 1) as pool:
            try:
                yield from _from(pool, waiting, count)
            except _Died as died:
                suspects = died.jobs
        # One of them has ended its process: each is begun again alone, so that none is blamed for another.
        for job in suspects:
            yield job, _alone(job, count > 1)


def _pool(count: int, one_thread: bool) -> concurrent.futures.ProcessPoolExecutor:
    # A process that has a device open cannot be forked.
    context = multiprocessing.get_context("spawn")
    return concurrent.futures.ProcessPoolExecutor(
        count, mp_context=context, initializer=_runs.begin_worker, initargs=(one_thread,)
    )


def _alone(job: dict[str, Any], one_thread: bool) -> _Result:
    for _ in range(ATTEMPTS):
        with _pool(1, one_thread) as pool:
            try:
                return pool.submit(_runs.do, job).result()
            except concurrent.futures.BrokenExecutor:
                continue
    return {"error": f"its process died {ATTEMPTS} times", "seconds": None}, None


def _from(
    executor: Any, waiting: deque[dict[str, Any]], most: int | None
) -> Iterator[tuple[dict[str, Any], _Result]]:
    """The results of jobs in the order in which they end; at most so many are under way."""
    pending: dict[Any, dict[str, Any]] = {}
    while waiting or pending:
        while waiting and (most is None or len(pending) < most):
            job = waiting.popleft()
            try:
                pending[executor.submit(_runs.do, job)] = job
            except concurrent.futures.BrokenExecutor:
                raise _Died([job, *pending.values()]) from None
        if all(isinstance(future, concurrent.futures.Future) for future in pending):
            ended, _ = concurrent.futures.wait(pending, return_when=concurrent.futures.FIRST_COMPLETED)
        else:
            ended = {future for future in pending if future.done()}
            if not ended:
                time.sleep(ASKS_EVERY)
        for future in ended:
            try:
                result = future.result()
            except concurrent.futures.BrokenExecutor:
                raise _Died(list(pending.values())) from None
            except concurrent.futures.CancelledError:
                raise
            except Exception as error:
                result = {"error": f"{type(error).__name__}: {error}", "seconds": None}, None
            yield pending.pop(future), result


def _fitting(device: Any) -> int:
    """One process on a device that was chosen, otherwise as many as there are processors."""
    if device is not None:
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


# The folder


def _claim(folder: Path, study: Mapping[str, Any], run: _runs.Run | None) -> None:
    """Writes what the study is into its folder, or checks that the folder is of this one."""
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    file = folder / "study.json"
    # In this order: another shard may begin at the same time.
    has_runs = any((folder / "runs").iterdir())
    fixed = json.loads(_plain(_fixed(study, run)))
    if not file.exists():
        if has_runs:
            raise ValueError(f"{folder}/runs has files, and no study.json that says of which study: choose another folder")
        _write(file, json.dumps(fixed, indent=2).encode())
        return
    before = json.loads(file.read_text(encoding="utf-8"))
    other = [key for key in fixed if before.get(key) != fixed[key]]
    if other:
        key = other[0]
        raise ValueError(
            f"{folder} holds another study: its {key} is {before.get(key)!r}, and here it is {fixed[key]!r}: choose another folder"
        )


def _row_file(folder: Path, job: Mapping[str, Any]) -> Path:
    return folder / "runs" / f"{job['key']}.json"


def _keep(folder: Path, job: Mapping[str, Any], row: Mapping[str, Any], packed: bytes | None) -> None:
    if packed is not None:
        (folder / "fields").mkdir(exist_ok=True)
        _write(folder / "fields" / f"{job['key']}.npz", packed)
    whole = {"run": job["number"], "seed": job["seed"], **job["point"], **row, "key": job["key"]}
    _write(_row_file(folder, job), _plain(whole, sort=False).encode())


def _write(file: Path, content: bytes) -> None:
    """Writes a file that is whole or not there."""
    part = file.with_name(f".{file.name}.{os.getpid()}.part")
    try:
        with open(part, "wb") as out:
            out.write(content)
            out.flush()
            os.fsync(out.fileno())
        os.replace(part, file)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def _table(folder: Path, library: Any, wanted: set[str] | None) -> pandas.DataFrame:
    files = [file for file in (folder / "runs").glob("*.json") if wanted is None or file.name in wanted]
    rows = [json.loads(file.read_text(encoding="utf-8")) for file in files]
    table: pandas.DataFrame = library.DataFrame(rows)
    if table.empty:
        return table
    last = [column for column in (*LAST, "key") if column in table]
    middle = [column for column in table if column not in FIRST and column not in last]
    sorted_table: pandas.DataFrame = table[[*FIRST, *middle, *last]].sort_values(list(FIRST), ignore_index=True)
    return sorted_table


def _write_table(folder: Path, library: Any) -> None:
    table = _table(folder, library, None)
    if table.empty:
        return
    # A column with lists has a text for each.
    for column in table:
        if table[column].map(lambda value: isinstance(value, (list, dict))).any():
            table[column] = table[column].map(json.dumps)
    _write(folder / "table.csv", table.to_csv(index=False).encode())
    file = io.BytesIO()
    table.to_parquet(file, index=False)
    _write(folder / "table.parquet", file.getvalue())


class _Lock:
    """Keeps other sweeps out of a folder; the system ends it with the process, however that ends."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __enter__(self) -> None:
        self.open = open(self.file, "w")
        try:
            import fcntl
        except ModuleNotFoundError:
            return
        try:
            fcntl.flock(self.open, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.open.close()
            raise RuntimeError(f"another sweep writes into {self.file.parent}: wait for it, or choose another folder") from None

    def __exit__(self, *_: object) -> None:
        self.open.close()


class _Progress:
    """A bar where tqdm is installed, a line now and then elsewhere."""

    def __init__(self, total: int, done: int) -> None:
        self.total, self.done, self.failed, self.said = total, done, 0, time.monotonic()
        try:
            from tqdm.auto import tqdm
        except ModuleNotFoundError:
            self.bar = None
        else:
            self.bar = tqdm(total=total, initial=done, unit="run", file=sys.stderr)

    def step(self, error: str | None) -> None:
        self.done += 1
        self.failed += error is not None
        if self.bar is not None:
            self.bar.update()
            if self.failed:
                self.bar.set_postfix(failed=self.failed)
        elif time.monotonic() - self.said > 5.0:
            self.said = time.monotonic()
            print(f"myxo: run {self.done} of {self.total}, {self.failed} failed", file=sys.stderr)

    def end(self) -> None:
        if self.bar is not None:
            self.bar.close()


def _pandas() -> Any:
    try:
        import pandas
        import pyarrow  # noqa: F401
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(f"sweeps need {error.name}: pip install 'myxo[sweep]'", name=error.name) from None
    return pandas
