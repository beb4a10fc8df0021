"""Sweeps: many runs over any executor, each written as soon as it is done."""

from __future__ import annotations

import concurrent.futures
import functools
import hashlib
import inspect
import io
import json
import math
import multiprocessing
import operator
import os
import shutil
import sys
import time
import warnings
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from . import _myxo, _runs
from ._points import Point, grid, sample
from ._scene import Scene, is_picture, source, with_files

if TYPE_CHECKING:
    import pandas


class Row(Protocol):
    """A row of a table: a dictionary, or a `pandas.Series`."""

    def __getitem__(self, key: str, /) -> Any: ...


# A run whose process dies is begun again alone so often.
ATTEMPTS = 3
# An executor without futures of the standard library is asked this often, seconds.
ASKS_EVERY = 0.2
# A column of the table has the name of its parameter; these stand before and after.
FIRST = ("run", "seed")
LAST = ("step", "state_hash", "seconds", "device", "commit", "error")


def sweep(
    points: str | os.PathLike[str] | Mapping[str, Iterable[Any]] | Iterable[Point],
    run: _runs.Run | None = None,
    *,
    out: str | os.PathLike[str],
    scene: str | os.PathLike[str] | Mapping[str, Any] | Scene | None = None,
    steps: int | None = None,
    seeds: int | Iterable[int] | None = None,
    preset: str | None = None,
    settings: Mapping[str, Any] | None = None,
    fields: Sequence[str] = (),
    store: str = "npz",
    picture: str | Sequence[int] | None = None,
    network: bool = False,
    executor: Any = None,
    workers: int | None = None,
    device: str | int | None = None,
    shard: tuple[int, int] | None = None,
    retry: bool = False,
    progress: bool = True,
) -> pandas.DataFrame:
    """Runs a scene at many points of its parameters, and returns a table with a row for each run.

        table = myxo.sweep(
            {"physarum.sensor_angle": [15, 30, 45], "physarum.rotation_angle": [15, 30, 45]},
            scene="plane", steps=400, seeds=3, out="angles",
        )

    A run that is done is written at once; asked for again, it is not run again. So a sweep that was ended goes on where it was, and
    one with more points or seeds runs only those. A run is done again if a file has changed that a value of its point names, such as a mesh
    or a map.

    Parameters
    ----------
    points
        A grid: values for each parameter. Or points: dictionaries with a value for each parameter (`myxo.grid`, `myxo.sample`). Or
        the path of a study file, which has scene, steps, seeds, preset and settings, too.
    run
        What a run does, in place of `sim.step(steps)`: a function of the simulation and the point, which returns numbers and texts for
        the row, and arrays for `fields`. It must be found by name in a module, as executors need it, or be a `functools.partial` of such
        a function. Names that the row has already, such as `seed`, `length` or a parameter of the point, are refused after the run.
        So the measures of `sim.network()`, of which one is `length`, are not returned: `network=True` adds them.
    out
        The folder: `table.parquet` and `table.csv`, `runs/` with a row for each run, `fields/` with arrays.
    scene, preset, settings
        As for `Simulation`; by default the scene `torus`. `settings` lie under the point's values. A study file has its own: with one,
        these are refused.
    steps
        Of each run; by default 400, or as many as the study file says.
    seeds
        So many from 0 on, or a list; by default one, or those of the study file.
    fields
        Arrays of each run that are kept: `trail`, `particles`, `deposits`, `texel_area`, ...
    store
        How they are kept: `npz`, a file for each run, or `zarr`, a folder for each run with arrays in chunks, of which parts can be
        read; `particles` become an array for each member, such as `particles.position`.
    picture
        Width and height, `(240, 240)` or `"240x240"`: each run writes a picture, `pictures/KEY.png`, in the view of the scene; in place of
        the size in a study file. A run without it is done again. If only the picture fails, row and fields stay, a warning says why, and
        so does `pictures/KEY.json`; it is tried again by `retry`.
        The program's `myxo sweep` draws a sheet of those of a study file with a grid.
    network
        Rows also get the measures of the graph of `sim.network()`, as `graph_nodes`, `graph_length` and so on to `graph_foods_tolerance`.
        A study file has the key `network`. Rows without them are done again.
    executor
        Anything with the `submit` of `concurrent.futures.Executor`, such as Dask's `client.get_executor()`, mpi4py's `MPIPoolExecutor` or
        an executor of submitit. By default, processes on this machine.
    workers
        The number of these processes; by default, on a driver that computes on the processor, as many as there are cores and memory
        for, and on a graphics card, which runs one kernel at a time, one.
    device
        As for `Simulation`.
    shard
        `(i, n)`: only each n-th run from the i-th on, counted from 0, for job arrays that share the folder.
    retry
        Runs failed runs again, and those whose picture could not be drawn.
    progress
        Shows how far it is.

    Returns
    -------
    pandas.DataFrame
        Columns `run` (number of the point), `seed`, each parameter, measures of the network, what `run` returned, `step`, `state_hash`,
        `seconds`, `device`, `commit` (that of the program) and `error` (None where all went well). A warning says how many runs have
        failed.

    Raises
    ------
    ValueError
        If the folder holds another study.
    TypeError
        If a study file is given together with a scene, a preset or settings.
    RuntimeError
        If another sweep writes into the folder.
    """
    library = _pandas()
    if store not in ("npz", "zarr"):
        raise ValueError(f"fields are stored as `npz` or `zarr`, not `{store}`")
    if store == "zarr":
        import zarr  # noqa: F401
    if isinstance(points, (str, os.PathLike)):
        study = read_study(points)
        for name, value, key in (("scene", scene, "scene"), ("preset", preset, "preset"), ("settings", settings, "[set]")):
            if value is not None:
                raise TypeError(f"`{name}` cannot be given with the study file {os.fspath(points)}: it stands there as `{key}`")
        given: dict[str, Any] = {"steps": steps, "seeds": seeds}
    else:
        study = {"points": points, "scene": "torus", "steps": 400, "seeds": 1, "preset": preset, "settings": settings}
        given = {"scene": scene, "steps": steps, "seeds": seeds}
    study.update({name: value for name, value in given.items() if value is not None})
    if picture is not None:
        study["picture"] = _size(picture)
    study["network"] = bool(network or study.get("network"))
    study = {**study, "settings": study["settings"] or {}}
    fixed = _fixed(study, run)
    jobs = _jobs(study, fixed, run, tuple(fields), device)
    numbers = {job["key"]: job["number"] for job in jobs}
    number, of = shard or (0, 1)
    folder = _myxo.Folder(out, _plain(fixed), (number, of))
    try:
        own = jobs[number::of]
        _settle_zarr(Path(out), {job["key"] for job in own})
        missing = [job for job in own if not folder.is_done(job["key"], retry, job["picture"])]
        if missing and missing[0]["picture"] is not None:
            _check_pictures(missing, executor)
        results = _results(missing, executor, workers, progress)
        bar = _Progress(len(own), len(own) - len(missing)) if progress and missing else None
        try:
            for job, (row, packed, drawn) in results:
                # A good row stays if its run, done again for the picture, fails.
                stays = row["error"] is not None and folder.is_done(job["key"], True, None)
                if stays:
                    drawn = row["error"]
                # First, so that a run that counts as done has all of it.
                if packed is not None and store == "zarr":
                    _write_zarr(Path(out), job["key"], packed)
                    packed = None
                if isinstance(drawn, str):
                    warnings.warn(f"run {job['number']} has no picture: {drawn}", RuntimeWarning, stacklevel=2)
                    folder.keep_undrawn(job["key"], job["picture"], drawn)
                elif drawn is not None:
                    folder.keep_picture(job["key"], drawn)
                if not stays:
                    whole = {"run": job["number"], "seed": job["seed"], **job["point"], **row, "key": job["key"]}
                    folder.keep(job["key"], _plain(whole), packed)
                if bar:
                    bar.step(row["error"])
        finally:
            results.close()
            if bar:
                bar.end()
            folder.write_table(numbers)
    finally:
        folder.close()
    table = _table(Path(out), library, numbers)
    failed = 0 if table.empty else int(table["error"].notna().sum())
    if failed:
        warnings.warn(f"{failed} of {len(table)} runs failed: see the column `error`", RuntimeWarning, stacklevel=2)
    return table


def read_study(path: str | os.PathLike[str]) -> dict[str, Any]:
    """A study file, as `myxo sweep` takes it: `scene`, `steps`, `seeds`, `preset`, `settings` and `points`, for `sweep`.

    Raises
    ------
    ValueError
        With the line, if a key or a value is wrong.
    """
    study: dict[str, Any] = json.loads(_myxo.read_study(path))
    return study


def read_sweep(out: str | os.PathLike[str]) -> pandas.DataFrame:
    """The table that the last sweep in a folder has written; those of a sweep that runs for the first time are the rows so far.

    Raises
    ------
    FileNotFoundError
        If the folder holds no sweep.
    """
    library = _pandas()
    table = Path(out) / "table.parquet"
    if not (table.is_file() or (Path(out) / "study.json").is_file()):
        raise FileNotFoundError(f"there is no sweep in {os.fspath(out)}: it has neither study.json nor table.parquet")
    # As long as the first sweep runs, there are only rows.
    return _with_none(library.read_parquet(table), library) if table.exists() else _table(Path(out), library, None)


def read_fields(out: str | os.PathLike[str], row: Row) -> Mapping[str, Any]:
    """The arrays of a run, given its row of the table: NumPy's, or Zarr's, which read what is asked of them."""
    fields = Path(out) / "fields"
    group = fields / f"{row['key']}.zarr"
    if group.exists():
        import zarr

        return {place.name: zarr.open_array(str(place), mode="r") for place in sorted(group.iterdir())}
    import numpy as np

    with np.load(fields / f"{row['key']}.npz") as file:
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


def _jobs(
    study: Mapping[str, Any], fixed: Mapping[str, Any], run: _runs.Run | None, fields: tuple[str, ...], device: Any
) -> list[dict[str, Any]]:
    points = study["points"]
    points = grid(points) if isinstance(points, Mapping) else [dict(point) for point in points]
    if not points:
        raise ValueError("there are no points: a sweep has one or more")
    seeds = _seeds(study["seeds"])
    if not seeds or min(seeds) < 0 or max(seeds) >= 2**32 or len(set(seeds)) < len(seeds):
        raise ValueError("seeds are one or more different numbers from 0 to 4294967295, or how many there are")
    # Pictures of maps stay arrays: files of this machine are not on others.
    settings = dict(study["settings"])
    _myxo.check_keys(sorted({key for point in [*points, settings] for key in point}))
    jobs: list[dict[str, Any]] = []
    # Only texts name files.
    named = [{key: value for key, value in point.items() if isinstance(value, (str, Mapping))} for point in points]
    contents = json.loads(_myxo.contents(_plain(named)))
    for number, (point, files) in enumerate(zip(points, contents)):
        whole = {**fixed, "point": point, "fields": fields, **({"files": files} if files else {})}
        if study["network"]:
            whole["network"] = True
        for seed in seeds:
            key = _myxo.run_key(_plain({**whole, "seed": seed}))
            jobs.append(
                {
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
                    "picture": study.get("picture"),
                    "network": study["network"],
                    "device": device,
                }
            )
    if len({job["key"] for job in jobs}) < len(jobs):
        raise ValueError("two points of the sweep are equal")
    return jobs


def _seeds(seeds: Any) -> list[int]:
    """A list of seeds, of one or of how many there are."""
    try:
        return list(range(operator.index(seeds)))
    except TypeError:
        if not isinstance(seeds, Iterable):
            raise TypeError(f"seeds are whole numbers, or how many there are, not {seeds!r}") from None
    try:
        return [operator.index(seed) for seed in seeds]
    except TypeError:
        raise TypeError(f"seeds are whole numbers, or how many there are, not {seeds!r}") from None


def _size(picture: str | Sequence[int]) -> list[int]:
    """Width and height of pictures, of numbers or of a text as in study files."""
    try:
        text = picture if isinstance(picture, str) else "x".join(str(operator.index(side)) for side in picture)
        size = _myxo.picture_size(text)
    except TypeError:
        size = None
    if size is None:
        sides = f"whole numbers from 1 to {_myxo.LONGEST_SIDE}"
        raise ValueError(f'picture is (width, height) or a text such as "240x240", in pixels: {sides}, not {picture!r}')
    return size


def _fixed(study: Mapping[str, Any], run: _runs.Run | None) -> dict[str, Any]:
    """What all runs of a study share, in a form that can be compared."""
    # Pictures of maps have names by their content.
    settings = with_files(study["settings"])
    return {
        "scene": _myxo.identity(source(study["scene"], study["preset"], settings)),
        "steps": None if run else study["steps"],
        # Studies are the same wherever their files lie. What a preset says is in the identity of the scene.
        "preset": Path(study["preset"]).name if study["preset"] else None,
        "settings": {key: _content(value) for key, value in settings.items()},
        "run": _name_of(run),
        "version": _myxo.version,
        "arithmetic": _myxo.arithmetic,
    }


def _content(value: Any) -> Any:
    """A value of a parameter; of a picture in memory its name alone, which is by its content."""
    return Path(value).name if is_picture(value) else value


def _name_of(run: _runs.Run | None) -> str | None:
    if run is None:
        return None
    if isinstance(run, functools.partial):
        bound = json.dumps(_bound([*run.args, dict(sorted(run.keywords.items()))]))
        return f"{_name_of(run.func)} with {hashlib.sha256(bound.encode()).hexdigest()[:12]}"
    if not hasattr(run, "__qualname__"):
        raise TypeError(f"run is a function of a module, or functools.partial of one, not a {type(run).__name__}")
    name = f"{run.__module__}.{run.__qualname__}"
    try:
        source = inspect.getsource(run)
    except (OSError, TypeError):
        return name
    return f"{name} {hashlib.sha256(source.encode()).hexdigest()[:12]}"


def _bound(value: Any) -> Any:
    """What `functools.partial` binds, in a form that is the same in every process."""
    if callable(value):
        return _name_of(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _bound(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_bound(item) for item in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    kinds = "numbers, texts, arrays, lists, dictionaries and functions"
    raise TypeError(f"functools.partial binds {kinds} to a run, not a {type(value).__name__}")


def _plain(value: Any) -> str:
    """JSON; numbers that are not finite, which it has not, are null."""
    def simple(item: Any) -> Any:
        return item.tolist() if hasattr(item, "tolist") else str(item)

    def finite(item: Any) -> Any:
        item = simple(item) if hasattr(item, "tolist") else item
        if isinstance(item, Mapping):
            return {str(key): finite(value) for key, value in item.items()}
        if isinstance(item, (list, tuple)):
            return [finite(value) for value in item]
        return None if isinstance(item, float) and not math.isfinite(item) else item

    return json.dumps(finite(value), default=simple)


# Doing it


class _Died(Exception):
    """A process of a pool ended; these runs were under way."""

    def __init__(self, jobs: list[dict[str, Any]]) -> None:
        self.jobs = jobs


def _results(
    jobs: list[dict[str, Any]], executor: Any, workers: int | None, says: bool
) -> Generator[tuple[dict[str, Any], _runs.Result], None, None]:
    waiting = deque(jobs)
    if executor is not None:
        try:
            yield from _from(executor, waiting, None)
        except _Died:
            raise RuntimeError("a process of the executor died; what is done is kept: begin the sweep again with another one") from None
        return
    if not waiting:
        return
    fitting, on_processor = _processes(jobs)
    count = fitting if workers is None else workers
    if count < 1:
        raise ValueError(f"workers is 1 or more, not {count}")
    count = min(count, len(jobs))
    threads = _myxo.threads(count) if count > 1 and on_processor else None
    if says:
        print(f"myxo: {len(jobs)} runs by {count} processes", file=sys.stderr)
    while waiting:
        suspects: list[dict[str, Any]] = []
        with _pool(count, threads) as pool:
            try:
                yield from _from(pool, waiting, count)
            except _Died as died:
                suspects = died.jobs
        # One of them has ended its process: each is begun again alone, so that none is blamed for another.
        for job in suspects:
            yield job, _alone(job, threads)


def _processes(jobs: list[dict[str, Any]]) -> tuple[int, bool]:
    """As many as there are cores and memory for; and do they compute on the processor?"""
    device = None if jobs[0]["device"] is None else str(jobs[0]["device"])
    sizes = json.loads(_myxo.largest(_plain([job["point"] for job in jobs])))
    settings = {**with_files(jobs[0]["settings"]), **sizes}
    scene = source(jobs[0]["scene"], jobs[0]["preset"], settings)
    return _myxo.processes(scene, device, jobs[0].get("picture"))


def _check_pictures(jobs: list[dict[str, Any]], executor: Any) -> None:
    """Refuses pictures that no run could draw. Executors of other machines have devices of their own, which are not asked."""
    job = jobs[0]
    pools = (concurrent.futures.ThreadPoolExecutor, concurrent.futures.ProcessPoolExecutor)
    here = executor is None or isinstance(executor, pools)
    # Functions may choose a view, and do other steps.
    one_view = job["run"] is None and not any("picture.show" in other["point"] for other in jobs)
    device = None if job["device"] is None else str(job["device"])
    scene = source(job["scene"], job["preset"], with_files(job["settings"]))
    _myxo.check_pictures(scene, device, job["steps"], job["picture"], one_view, here)


def _pool(count: int, threads: int | None) -> concurrent.futures.ProcessPoolExecutor:
    # A process that has a device open cannot be forked.
    context = multiprocessing.get_context("spawn")
    return concurrent.futures.ProcessPoolExecutor(
        count, mp_context=context, initializer=_runs.begin_worker, initargs=(threads,)
    )


def _alone(job: dict[str, Any], threads: int | None) -> _runs.Result:
    for _ in range(ATTEMPTS):
        with _pool(1, threads) as pool:
            try:
                return pool.submit(_runs.do, job).result()
            except concurrent.futures.BrokenExecutor:
                continue
    return {"error": f"its process died {ATTEMPTS} times", "seconds": None, "commit": _myxo.commit()}, None, None


def _from(
    executor: Any, waiting: deque[dict[str, Any]], most: int | None
) -> Iterator[tuple[dict[str, Any], _runs.Result]]:
    """The results of jobs in the order in which they end; at most so many are under way."""
    pending: dict[Any, dict[str, Any]] = {}
    try:
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
                    result = {"error": f"{type(error).__name__}: {error}", "seconds": None, "commit": _myxo.commit()}, None, None
                yield pending.pop(future), result
    finally:
        # After an error the others are not begun any more.
        for future in pending:
            future.cancel()


# The folder


def _write_zarr(folder: Path, key: str, packed: bytes) -> None:
    """Writes arrays as a folder of Zarr arrays, which is whole or not there."""
    import numpy as np
    import zarr

    fields = folder / "fields"
    part, old, group = fields / f".{key}.{os.getpid()}.part", fields / f".{key}.old", fields / f"{key}.zarr"
    fields.mkdir(exist_ok=True)
    try:
        with np.load(io.BytesIO(packed)) as file:
            for name in file.files:
                array: Any = file[name]
                # Rows with several members, such as particles, become an array for each of them.
                members = {f"{name}.{member}": array[member] for member in array.dtype.names or ()}
                for own, values in (members or {name: array}).items():
                    whole: Any = np.ascontiguousarray(values)
                    zarr.save_array(str(part / own), whole)
        for file in part.rglob("*"):
            if file.is_file():
                with open(file, "rb") as written:
                    os.fsync(written.fileno())
        # One that is there may be of a run that lacks its picture alone: it is there until the other one is.
        shutil.rmtree(old, ignore_errors=True)
        if group.exists():
            os.replace(group, old)
        os.replace(part, group)
        shutil.rmtree(old, ignore_errors=True)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        if old.exists() and not group.exists():
            os.replace(old, group)
        raise


def _settle_zarr(folder: Path, keys: set[str]) -> None:
    """Puts back what a killed process was replacing of these runs, and removes what it has left."""
    for left in (folder / "fields").glob(".*"):
        # As `_write_zarr` names them.
        key = left.name.split(".")[1]
        group = left.with_name(f"{key}.zarr")
        if key not in keys or left.suffix not in (".part", ".old"):
            continue
        if left.suffix == ".old" and not group.exists():
            os.replace(left, group)
        else:
            shutil.rmtree(left, ignore_errors=True)


def _table(folder: Path, library: Any, numbers: Mapping[str, int] | None) -> pandas.DataFrame:
    """The rows that are done: all, or those of some keys, with the numbers of their points."""
    files = [file for file in (folder / "runs").glob("*.json") if numbers is None or file.stem in numbers]
    rows = [json.loads(file.read_text(encoding="utf-8")) for file in files]
    if numbers is not None:
        for row in rows:
            row["run"] = numbers[row["key"]]
    rows.sort(key=lambda row: (row["run"], row["seed"]))
    table: pandas.DataFrame = library.DataFrame(rows)
    if table.empty:
        return table
    last = [column for column in (*LAST, "key") if column in table]
    middle = [column for column in table if column not in FIRST and column not in last]
    ordered: pandas.DataFrame = table[[*FIRST, *middle, *last]]
    return _with_none(ordered, library)


def _with_none(table: pandas.DataFrame, library: Any) -> pandas.DataFrame:
    """The table, in which the error of a run that went well is None, whatever pandas takes for a text that is missing."""
    if "error" not in table:
        return table
    errors = [error if isinstance(error, str) else None for error in table["error"]]
    return table.assign(error=library.Series(errors, index=table.index, dtype=object))


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
        raise ModuleNotFoundError(f"sweeps need {error.name}: pip install '.[sweep]' in the clone", name=error.name) from None
    return pandas
