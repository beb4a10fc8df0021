"""One run of a sweep, as a worker does it."""

from __future__ import annotations

import io
import json
import os
import time
from collections.abc import Callable, Mapping
from typing import Any

Run = Callable[..., Mapping[str, Any]]
# A row, fields as the bytes of an NPZ file, and a picture as the bytes of a PNG, or why there is none.
Result = tuple[dict[str, Any], bytes | None, bytes | str | None]


def begin_worker(threads: int | None) -> None:
    """Prepares a process that does runs side by side with others, which share the cores on drivers that compute on the processor."""
    if threads is not None:
        os.environ.setdefault("LP_NUM_THREADS", str(threads))
        os.environ.setdefault("RAYON_NUM_THREADS", str(threads))


def do(job: Mapping[str, Any]) -> Result:
    """Does a run. What fails is a row with its error; if only the picture fails, the row and the fields have none."""
    row: dict[str, Any] = {}
    begun = time.perf_counter()
    fields: dict[str, Any] = {}
    file: bytes | None = None
    picture: bytes | str | None = None
    try:
        from ._myxo import commit, encode_png
        from ._simulation import Simulation

        row["commit"] = commit()
        scene, steps, run = job["scene"], job["steps"], job["run"]
        settings = {**job["settings"], **job["point"]}
        with Simulation(
            scene, seed=job["seed"], preset=job["preset"], settings=settings, device=job["device"]
        ) as sim:
            if run is None:
                sim.step(steps)
                found: Mapping[str, Any] = {}
            else:
                found = run(sim, dict(job["point"])) or {}
            row["step"] = sim.steps
            row["state_hash"] = sim.state_hash
            measures = sim.measures()
            row.update({key: value for key, value in measures.items() if isinstance(value, (int, float))})
            if job["network"]:
                columns = json.loads(sim._engine.network_columns())
                row.update({f"graph_{name}": value for name, value in columns})
            row["device"] = sim.device
            for name in job["fields"]:
                fields[name] = getattr(sim, name)
            taken = {"run", "seed", "seconds", "error", "key", *row, *job["point"], *fields}
            for name, value in found.items():
                if name in taken:
                    # As those of `sim.network()`.
                    or_graph = ", or sweep with `network=True` for measures of the graph" if "mean_degree" in found else ""
                    raise ValueError(f"the run returns `{name}`, which the table has already: give it another name{or_graph}")
                if hasattr(value, "ndim") and value.ndim > 0:
                    fields[name] = value
                else:
                    row[name] = value.item() if hasattr(value, "item") else value
            if job["picture"] is not None:
                width, height = job["picture"]
                try:
                    picture = encode_png(sim.render(width, height))
                except Exception as error:  # The picture alone is missing.
                    picture = _text(error)
        file = packed(fields)
        row["error"] = None
    except Exception as error:  # A row says what went wrong, and the sweep goes on.
        row["error"] = _text(error)
        picture = None
    row["seconds"] = round(time.perf_counter() - begun, 3)
    return row, file, picture


def _text(error: Exception) -> str:
    text = error.args[0] if isinstance(error, KeyError) and error.args else error
    return f"{type(error).__name__}: {text}"


def packed(fields: Mapping[str, Any]) -> bytes | None:
    """Arrays as the bytes of an NPZ file, if there are any."""
    if not fields:
        return None
    import numpy as np

    for name, array in fields.items():
        if np.asarray(array).dtype.hasobject:
            raise TypeError(f"the array `{name}` has objects of Python, which are not stored")
    file = io.BytesIO()
    np.savez_compressed(file, **fields)
    return file.getvalue()
