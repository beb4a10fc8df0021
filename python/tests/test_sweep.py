"""Sweeps: the same table by any executor, whatever dies on the way."""

import concurrent.futures
import json
import os
import signal
import subprocess
import sys
import time

import myxo
import numpy as np
import pytest

SETTINGS = {"particles.count": 500, "atlas.size": 64}
STUDY = {"scene": "cube", "steps": 5, "settings": SETTINGS, "progress": False}
ANGLES = {"physarum.sensor_angle": [15.0, 30.0], "trail.decay": [0.9, 0.95]}


def hashes(table):
    return {(row["run"], row["seed"]): row["state_hash"] for _, row in table.iterrows()}


def beginning(sim, point):
    """A run of its own: fewer steps, a number and an array."""
    if point["trail.decay"] > 0.94:
        raise RuntimeError("no such decay here")
    sim.step(2)
    return {"twice": 2 * point["trail.decay"], "fine": np.bool_(True), "mine": np.arange(3)}


def dies_once(sim, point):
    """Ends its process, but for the second time."""
    mark = os.environ["MYXO_TEST_MARK"]
    if not os.path.exists(mark):
        open(mark, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    sim.step(2)
    return {}


def dies_at_low_decay(sim, point):
    """Ends its process at every second point."""
    if point["trail.decay"] < 0.92:
        os.kill(os.getpid(), signal.SIGKILL)
    sim.step(2)
    return {}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("whole")
    return out, myxo.sweep(ANGLES, out=out, seeds=2, workers=2, fields=("trail",), **STUDY)


def test_every_run_is_a_row_and_the_same_as_alone(whole):
    out, table = whole
    assert len(table) == 8 and table["error"].isna().all()
    assert list(table.columns[:4]) == ["run", "seed", "physarum.sensor_angle", "trail.decay"]
    row = table.iloc[3]
    settings = {**SETTINGS, **{key: row[key] for key in ANGLES}}
    with myxo.Simulation("cube", seed=int(row["seed"]), settings=settings) as sim:
        assert sim.step(5).state_hash == row["state_hash"]
        assert sim.measures()["length"] == pytest.approx(row["length"])
        assert (myxo.read_fields(out, row)["trail"] == sim.trail).all()
    assert table["state_hash"].nunique() == 8
    import pandas

    assert hashes(pandas.read_parquet(out / "table.parquet")) == hashes(table)
    assert hashes(pandas.read_csv(out / "table.csv", dtype={"state_hash": str})) == hashes(table)
    assert hashes(myxo.read_sweep(out)) == hashes(table)
    data = myxo.to_dataset(table, *ANGLES)
    assert dict(data.sizes) == {"physarum.sensor_angle": 2, "trail.decay": 2, "seed": 2}
    with pytest.raises(ValueError, match="name all parameters"):
        myxo.to_dataset(table, "trail.decay")


def test_what_is_done_is_not_run_again_and_more_points_join(whole):
    out, table = whole
    before = {file: file.stat().st_mtime_ns for file in (out / "runs").iterdir()}
    no_workers = object()
    again = myxo.sweep(ANGLES, out=out, seeds=2, fields=("trail",), executor=no_workers, **STUDY)
    assert hashes(again) == hashes(table)
    assert before == {file: file.stat().st_mtime_ns for file in (out / "runs").iterdir()}
    gone = sorted((out / "runs").iterdir())[2]
    gone.unlink()
    again = myxo.sweep(ANGLES, out=out, seeds=2, workers=1, fields=("trail",), **STUDY)
    assert hashes(again) == hashes(table) and gone.exists()


def test_shards_make_the_same_table(whole, tmp_path):
    _, table = whole
    for shard in ((0, 3), (2, 3), (1, 3)):
        with concurrent.futures.ThreadPoolExecutor(1) as threads:
            part = myxo.sweep(
                ANGLES, out=tmp_path, seeds=2, shard=shard, executor=threads, fields=("trail",), **STUDY
            )
    assert hashes(part) == hashes(table)
    with pytest.raises(ValueError, match="shard"):
        myxo.sweep(ANGLES, out=tmp_path, shard=(3, 3), **STUDY)


def test_failed_runs_are_rows_with_their_error(tmp_path):
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        table = myxo.sweep(ANGLES, beginning, out=tmp_path, executor=threads, **STUDY)
        bad = {"trail.decay": [0.9, 7.0]}
        wrong = myxo.sweep(bad, out=tmp_path / "b", executor=threads, **STUDY)
    failed = table["error"].notna()
    assert failed.sum() == 2 and (table["error"][failed] == "RuntimeError: no such decay here").all()
    assert (table["step"][~failed] == 2).all() and table["twice"][~failed].tolist() == [1.8, 1.8]
    assert (myxo.read_fields(tmp_path, table[~failed].iloc[0])["mine"] == np.arange(3)).all()
    assert wrong["error"].notna().tolist() == [False, True] and "trail.decay" in wrong["error"][1]


def test_a_process_that_dies_is_replaced(tmp_path, monkeypatch):
    monkeypatch.setenv("MYXO_TEST_MARK", str(tmp_path / "mark"))
    table = myxo.sweep(ANGLES, dies_once, out=tmp_path / "out", workers=2, **STUDY)
    assert len(table) == 4 and table["error"].isna().all()


def test_a_run_that_always_dies_is_a_row_and_blames_no_other(tmp_path):
    points = [{"trail.decay": decay} for decay in (0.95, 0.9, 0.96, 0.97, 0.98)]
    table = myxo.sweep(points, dies_at_low_decay, out=tmp_path, workers=2, **STUDY)
    assert table["error"].notna().tolist() == [False, True, False, False, False]
    assert table["error"][1] == "its process died 3 times" and table["step"][2] == 2


def test_a_killed_sweep_goes_on_where_it_was(whole, tmp_path):
    _, table = whole
    code = (
        "import myxo\n"
        f"myxo.sweep({ANGLES!r}, out={str(tmp_path)!r}, seeds=2, workers=1, fields=('trail',), **{STUDY!r})\n"
    )
    script = tmp_path / "script.py"
    script.write_text("if __name__ == '__main__':\n    " + code.replace("\n", "\n    "))
    process = subprocess.Popen([sys.executable, str(script)], start_new_session=True)
    runs = tmp_path / "runs"
    limit = time.monotonic() + 120
    while not (runs.exists() and len(list(runs.glob("*.json"))) >= 2):
        assert time.monotonic() < limit and process.poll() is None
        time.sleep(0.02)
    with pytest.raises(RuntimeError, match="another sweep writes"):
        myxo.sweep(ANGLES, out=tmp_path, seeds=2, workers=1, fields=("trail",), **STUDY)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    done = {file.name for file in runs.glob("*.json")}
    assert 2 <= len(done) < 8
    stamps = {name: (runs / name).stat().st_mtime_ns for name in done}
    again = myxo.sweep(ANGLES, out=tmp_path, seeds=2, workers=1, fields=("trail",), **STUDY)
    assert hashes(again) == hashes(table)
    assert stamps == {name: (runs / name).stat().st_mtime_ns for name in done}


def test_another_study_and_wrong_points_are_refused(whole, tmp_path):
    out, _ = whole
    with pytest.raises(ValueError, match="another study: its steps is 5, and here it is 6"):
        myxo.sweep(ANGLES, out=out, **{**STUDY, "steps": 6})
    with pytest.raises(KeyError, match="physarum.sped"):
        myxo.sweep({"physarum.sped": [1]}, out=tmp_path, **STUDY)
    with pytest.raises(ValueError, match="no points"):
        myxo.sweep([], out=tmp_path, **STUDY)
    with pytest.raises(TypeError, match="a list is needed"):
        myxo.sweep({"trail.decay": 0.9}, out=tmp_path, **STUDY)
    with pytest.raises(ValueError, match="no way of sampling"):
        myxo.sample({"trail.decay": (0.8, 0.9)}, 4, method="dice")
    with pytest.raises(ValueError, match="first below the second"):
        myxo.sample({"trail.decay": (0.9, 0.8)}, 4)


def test_samples_lie_in_their_ranges_and_repeat():
    ranges = {"trail.decay": (0.8, 0.9), "physarum.speed": (0.001, 0.01)}
    for method in ("random", "latin", "sobol"):
        points = myxo.sample(ranges, 16, method=method, seed=3)
        assert points == myxo.sample(ranges, 16, method=method, seed=3)
        for key, (low, high) in ranges.items():
            values = sorted(point[key] for point in points)
            assert low <= values[0] < values[-1] <= high
            if method != "random":
                # One in each sixteenth.
                assert [int(16 * (value - low) / (high - low)) for value in values] == list(range(16))


def test_a_study_file_says_the_same(whole, tmp_path):
    _, table = whole
    study = tmp_path / "study.toml"
    study.write_text(
        'scene = "cube"\nsteps = 5\nseeds = 2\n[set]\n"particles.count" = 500\n"atlas.size" = 64\n'
        '[grid]\n"physarum.sensor_angle" = [15.0, 30.0]\n"trail.decay" = [0.9, 0.95]\n'
    )
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        found = myxo.sweep(study, out=tmp_path / "out", executor=threads, progress=False)
    assert hashes(found) == hashes(table)
    study.write_text('scenes = "cube"\n[grid]\n')
    with pytest.raises(ValueError, match="no key `scenes`"):
        myxo.sweep(study, out=tmp_path / "b")
    study.write_text('scene = "cube"\n')
    with pytest.raises(ValueError, match="one of"):
        myxo.sweep(study, out=tmp_path / "b")


def test_dask_goes_on_when_a_worker_is_killed(whole, tmp_path):
    distributed = pytest.importorskip("distributed")
    _, table = whole
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = client.run(os.getpid)
        victim = sorted(pids.values())[0]
        executor = client.get_executor()
        killed = []

        def submit(*arguments):
            future = original(*arguments)
            if not killed:
                killed.append(victim)
                os.kill(victim, signal.SIGKILL)
            return future

        original, executor.submit = executor.submit, submit
        found = myxo.sweep(ANGLES, out=tmp_path, seeds=2, executor=executor, fields=("trail",), **STUDY)
    assert killed and hashes(found) == hashes(table)


class Asked:
    """An executor whose jobs are no futures of the standard library, as those of batch systems."""

    class Job:
        def __init__(self, function, arguments):
            self.left, self.call = 2, lambda: function(*arguments)

        def done(self):
            self.left -= 1
            return self.left < 0

        def result(self):
            return self.call()

    def submit(self, function, *arguments):
        return self.Job(function, arguments)


def test_executors_that_have_to_be_asked_do_as_well(whole, tmp_path):
    _, table = whole
    found = myxo.sweep(ANGLES, out=tmp_path, seeds=2, executor=Asked(), fields=("trail",), **STUDY)
    assert hashes(found) == hashes(table)
    kept = json.loads((tmp_path / "study.json").read_text())
    assert kept["steps"] == 5 and kept["version"] == myxo.__version__
