"""Sweeps: the same table by any executor, whatever dies on the way."""

import concurrent.futures
import functools
import json
import os
import pickle
import signal
import subprocess
import sys
import time

import myxo
import numpy as np
import pytest
from myxo._sweep import _name_of

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


def scaled(sim, point, factor):
    return {"scaled": factor * point["trail.decay"]}


class Scaled:
    """No function."""

    def __call__(self, sim, point):
        return {}


def names(sim, point, name):
    """Returns one number by a name."""
    return {name: 7.0}


def measures_of_the_graph(sim, point):
    """Returns names that rows have already."""
    sim.step(2)
    return sim.network()["measures"]


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


def fails_at_first(sim, point):
    """Fails the first time that it is called."""
    mark = os.environ["MYXO_TEST_MARK"]
    sim.step(1)
    if not os.path.exists(mark):
        open(mark, "w").close()
        raise RuntimeError("not yet")
    return {"nothing": float("nan")}


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
    assert (table["particles"] == 500).all() and table["commit"].fillna("").eq(myxo._myxo.commit() or "").all()
    import pandas

    assert hashes(pandas.read_parquet(out / "table.parquet")) == hashes(table)
    assert hashes(pandas.read_csv(out / "table.csv", dtype={"state_hash": str})) == hashes(table)
    assert hashes(myxo.read_sweep(out)) == hashes(table)
    data = myxo.to_dataset(table, *ANGLES)
    assert dict(data.sizes) == {"physarum.sensor_angle": 2, "trail.decay": 2, "seed": 2}
    with pytest.raises(ValueError, match="name all parameters"):
        myxo.to_dataset(table, "trail.decay")


def test_rows_have_measures_of_the_graph(whole, tmp_path):
    """Catches measures of another graph, rows without them that count as done, and a program that does these runs again."""
    _, table = whole
    study = tmp_path / "study.toml"
    study.write_text("network = true\n" + STUDY_FILE.replace("seeds = 2", "seeds = [1]"))
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        plain = myxo.sweep(ANGLES, out=tmp_path / "out", seeds=[1], executor=threads, **STUDY)
        assert not any(name.startswith("graph_") for name in plain)
        found = myxo.sweep(ANGLES, out=tmp_path / "out", seeds=[1], network=True, executor=threads, **STUDY)
        mistaken = myxo.sweep({"trail.decay": [0.9]}, measures_of_the_graph, out=tmp_path / "own", executor=threads, **STUDY)
    assert hashes(found) == hashes(plain) == hashes(table[table["seed"] == 1])
    row = found.iloc[0]
    settings = {**SETTINGS, **{key: row[key] for key in ANGLES}}
    with myxo.Simulation("cube", seed=1, settings=settings) as sim:
        measures = sim.step(5).network()["measures"]
    assert measures.pop("foods") is None and found["graph_foods_reached"].isna().all()
    assert {name: row[f"graph_{name}"] for name in measures} == measures
    assert "`length`" in mistaken["error"][0] and "network=True" in mistaken["error"][0]
    # The study file says the same.
    no_workers = object()
    again = myxo.sweep(study, out=tmp_path / "out", executor=no_workers, progress=False)
    assert hashes(again) == hashes(found)
    assert "to do" not in sweep_of_program(study, tmp_path / "out")


def test_what_is_done_is_not_run_again_and_more_points_join(whole):
    out, table = whole
    before = {file: file.stat().st_mtime_ns for file in (out / "runs").iterdir()}
    no_workers = object()
    again = myxo.sweep(ANGLES, out=out, seeds=2, fields=("trail",), executor=no_workers, **STUDY)
    assert hashes(again) == hashes(table)
    assert before == {file: file.stat().st_mtime_ns for file in (out / "runs").iterdir()}
    # However its numbers are written.
    whole_numbers = {"physarum.sensor_angle": [15, 30], "trail.decay": ANGLES["trail.decay"]}
    study = {**STUDY, "settings": {**SETTINGS, "particles.count": 500.0}}
    again = myxo.sweep(whole_numbers, out=out, seeds=np.int64(2), fields=("trail",), executor=no_workers, **study)
    assert hashes(again) == hashes(table)
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
        with pytest.warns(RuntimeWarning, match="1 of 2 runs failed: see the column `error`"):
            wrong = myxo.sweep(bad, out=tmp_path / "b", executor=threads, **STUDY)
    failed = table["error"].notna()
    assert failed.sum() == 2 and (table["error"][failed] == "RuntimeError: no such decay here").all()
    assert (table["step"][~failed] == 2).all() and table["twice"][~failed].tolist() == [1.8, 1.8]
    assert (myxo.read_fields(tmp_path, table[~failed].iloc[0])["mine"] == np.arange(3)).all()
    assert wrong["error"].notna().tolist() == [False, True] and "trail.decay" in wrong["error"][1]
    assert wrong["error"][0] is None and myxo.read_sweep(tmp_path / "b")["error"][0] is None


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
    not_text = "preset is a text, the name of a preset or the path of one, not 3"
    with pytest.raises(TypeError, match=not_text):
        myxo.sweep(ANGLES, out=tmp_path, preset=3, **STUDY)
    scene = myxo.Scene({"particles.count": 500}, preset=3).add("cube", "builtin:cube")
    with pytest.raises(TypeError, match=not_text):
        myxo.sweep(ANGLES, out=tmp_path, **{**STUDY, "scene": scene})
    with pytest.raises(ValueError, match="no points"):
        myxo.sweep([], out=tmp_path, **STUDY)
    with pytest.raises(TypeError, match="seeds are whole numbers, or how many there are, not 2.5"):
        myxo.sweep(ANGLES, out=tmp_path, seeds=2.5, **STUDY)
    with pytest.raises(FileNotFoundError, match="there is no sweep in .*nowhere"):
        myxo.read_sweep(tmp_path / "nowhere")
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
        counts = [point["particles.count"] for point in myxo.sample({"particles.count": (4.5, 8)}, 32, method=method)]
        assert {type(count) for count in counts} == {int}
        assert sorted(counts) == [5, 6, 7, 8], method
    with pytest.raises(ValueError, match="no whole number"):
        myxo.sample({"particles.count": (4.2, 4.8)}, 4)


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
    # What is given is not ignored.
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        other = myxo.sweep(study, out=tmp_path / "c", seeds=[1], steps=2, executor=threads, progress=False)
    assert len(other) == 4 and (other["seed"] == 1).all() and (other["step"] == 2).all()
    for name, value in (("scene", "torus"), ("preset", "lace"), ("settings", {})):
        with pytest.raises(TypeError, match=f"`{name}` cannot be given with the study file .*study.toml"):
            myxo.sweep(study, out=tmp_path / "b", **{name: value})
    study.write_text('scenes = "cube"\n[grid]\n')
    with pytest.raises(ValueError, match="study.toml:1: there is no key `scenes`"):
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


MPI = """
import sys
import myxo
from mpi4py.futures import MPIPoolExecutor

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        myxo.sweep(sys.argv[1], out=sys.argv[2], fields=("trail",), executor=executor, progress=False)
"""
STUDY_FILE = """
scene = "cube"
steps = 5
seeds = 2
[set]
"particles.count" = 500
"atlas.size" = 64
[grid]
"physarum.sensor_angle" = [15.0, 30.0]
"trail.decay" = [0.9, 0.95]
"""
# Numbers of 16 digits and more, which not every reader of JSON gives back as they were
LONG = STUDY_FILE.replace("[set]", '[set]\n"physarum.speed" = 0.009125373295837779').replace("0.95", "0.9312537329583777")


def test_mpi_gives_the_same_table(whole, tmp_path):
    """Catches jobs and rows that cannot go from one MPI process to another."""
    out, table = whole
    script, study = tmp_path / "script.py", tmp_path / "study.toml"
    script.write_text(MPI)
    study.write_text(STUDY_FILE)
    command = ["mpiexec", "--allow-run-as-root", "--oversubscribe", "-n", "3", sys.executable, "-m", "mpi4py.futures"]
    subprocess.run([*command, str(script), str(study), str(tmp_path / "out")], check=True, timeout=250)
    found = myxo.read_sweep(tmp_path / "out")
    assert hashes(found) == hashes(table)
    assert (myxo.read_fields(tmp_path / "out", found.iloc[5])["trail"] == myxo.read_fields(out, table.iloc[5])["trail"]).all()


def test_jobs_of_a_batch_system_give_the_same_table(whole, tmp_path):
    """Catches jobs that a file cannot carry, and results that are asked for in another way than futures."""
    import submitit

    _, table = whole
    executor = submitit.LocalExecutor(tmp_path / "logs")
    executor.update_parameters(timeout_min=5)
    found = myxo.sweep(ANGLES, out=tmp_path / "out", executor=executor, **STUDY)
    first = table[table["seed"] == 0]
    assert hashes(found) == hashes(first)


def sweep_of_program(study, out):
    """What `myxo sweep` says."""
    program = os.environ.get("MYXO_PROGRAM")
    if program is None:
        pytest.skip("MYXO_PROGRAM names no program")
    command = [program, "sweep", str(study), "--out", str(out)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stderr


def test_the_program_goes_on_with_a_folder(tmp_path):
    """Catches two formats of one folder: names of runs, rows, and the study that all have in common."""
    study = tmp_path / "study.toml"
    study.write_text(LONG.replace("seeds = 2", "seeds = [1]"))
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        myxo.sweep(study, out=tmp_path / "out", executor=threads, progress=False)
    study.write_text(LONG)
    assert "4 of 8 runs to do" in sweep_of_program(study, tmp_path / "out")
    found = myxo.read_sweep(tmp_path / "out")
    table = myxo.sweep(study, out=tmp_path / "alone", workers=1, progress=False)
    assert hashes(found) == hashes(table)
    measures = ["key", "physarum.sensor_angle", "trail.decay", "mean_trail", "length", "pieces", "device"]
    assert (found[measures] == table[measures]).all().all()


def test_a_picture_that_cannot_be_drawn_costs_no_result(tmp_path):
    """Catches rows and fields that are lost with a picture, when first done or later, and runs that are done again and again for it."""
    points = {"picture.show": ["distance", "atlas"]}
    study = {**STUDY, "fields": ("trail",)}
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        plain = myxo.sweep(points, out=tmp_path / "later", executor=threads, **study)
        for out in (tmp_path / "at once", tmp_path / "later"):
            with pytest.warns(RuntimeWarning, match="run 0 has no picture: ValueError: the view .* cannot be shown"):
                table = myxo.sweep(points, out=out, executor=threads, picture=(40, 30), **study)
            assert hashes(table) == hashes(plain) and table["error"].isna().all()
            assert all(myxo.read_fields(out, row)["trail"].any() for _, row in table.iterrows())
            assert len(list((out / "pictures").glob("*.png"))) == 1
            no_workers = object()
            again = myxo.sweep(points, out=out, executor=no_workers, picture=(40, 30), **study)
            assert again.equals(table)
        with pytest.warns(RuntimeWarning, match="run 0 has no picture"):
            myxo.sweep(points, out=out, executor=threads, picture=(40, 30), retry=True, **study)


def test_pictures_that_no_run_can_draw_are_refused(whole, tmp_path):
    """Catches a study that does all of its runs, and then has none of its pictures."""
    blind = {**STUDY, "settings": {**SETTINGS, "picture.show": "distance"}}
    with pytest.raises(ValueError, match="the view distance cannot be shown"):
        myxo.sweep(ANGLES, out=tmp_path, executor=object(), picture=(40, 30), **blind)
    _, table = whole
    # Large cards have room for it.
    if "llvmpipe" in table["device"][0]:
        with pytest.raises(ValueError, match="16384 x 16384"):
            myxo.sweep(ANGLES, out=tmp_path / "large", workers=1, picture=(16384, 16384), **STUDY)
    assert not list(tmp_path.glob("**/runs/*"))
    for size in ((0, 30), (240.9, 1.5), (240,), (1, 2, 3), "240", "0x30", "16385x1", 240):
        with pytest.raises(ValueError, match=r"picture is \(width, height\) or a text such as"):
            myxo.sweep(ANGLES, out=tmp_path / "b", executor=object(), picture=size, **STUDY)


def test_runs_have_pictures(whole, tmp_path):
    """Catches runs that count as done without their picture, and a program that draws them again before it makes a sheet of them."""
    _, table = whole
    file = tmp_path / "study.toml"
    file.write_text(
        'scene = "cube"\nsteps = 5\npicture = "40x30"\n[set]\n"particles.count" = 500\n"atlas.size" = 64\n'
        '[grid]\n"physarum.sensor_angle" = [15.0, 30.0]\n"trail.decay" = [0.9, 0.95]\n'
    )
    out = tmp_path / "out"
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        found = myxo.sweep(file, out=out, executor=threads, progress=False)
        assert hashes(found) == hashes(table[table["seed"] == 0])
        pictures = {out / "pictures" / f"{key}.png": key for key in found["key"]}
        assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
        lost = next(iter(pictures))
        lost.unlink()
        myxo.sweep(ANGLES, out=out, executor=threads, picture=(40, 30), **STUDY)
        assert lost.exists()
        # The size here is in place of the file's.
        myxo.sweep(file, out=tmp_path / "c", executor=threads, picture="20x10", progress=False)
        sizes = {picture.read_bytes()[16:24] for picture in (tmp_path / "c" / "pictures").iterdir()}
        assert sizes == {(20).to_bytes(4, "big") + (10).to_bytes(4, "big")}
    assert "to do" not in sweep_of_program(file, out)
    assert (out / "sheet.png").exists()


def test_fields_in_zarr_are_the_same(whole, tmp_path):
    out, table = whole
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        found = myxo.sweep(ANGLES, out=tmp_path, executor=threads, fields=("trail", "particles"), store="zarr", **STUDY)
    one = found.iloc[2]
    same = table[(table["run"] == one["run"]) & (table["seed"] == one["seed"])].iloc[0]
    kept = myxo.read_fields(tmp_path, one)
    trail = kept["trail"]
    assert kept["particles.position"].shape == (500, 3) and (np.unique(kept["particles.object"]) == [0]).all()
    assert trail.shape == (64, 64)
    assert (trail[10:20] == myxo.read_fields(out, same)["trail"][10:20]).all()
    with pytest.raises(ValueError, match="as `npz` or `zarr`, not `hdf`"):
        myxo.sweep(ANGLES, out=tmp_path, store="hdf", **STUDY)


def test_fields_in_zarr_are_there_until_others_are(tmp_path, monkeypatch):
    """Catches fields of a good run that are lost when a sweep ends while it replaces them."""
    from myxo import _sweep
    from myxo._runs import packed

    key = "0123456789abcdef"
    fields, group = tmp_path / "fields", tmp_path / "fields" / f"{key}.zarr"

    def write(value):
        _sweep._write_zarr(tmp_path, key, packed({"a": np.full(3, value)}))

    def kept():
        assert [file.name for file in fields.iterdir()] == [group.name]
        return myxo.read_fields(tmp_path, {"key": key})["a"][:].tolist()

    write(1)
    replace = os.replace

    def fails(source, target):
        if os.fspath(source).endswith(".part"):
            raise OSError("no room")
        replace(source, target)

    with monkeypatch.context() as patch, pytest.raises(OSError, match="no room"):
        patch.setattr(os, "replace", fails)
        write(2)
    assert kept() == [1, 1, 1]
    write(2)
    assert kept() == [2, 2, 2]
    # As a process leaves them that is killed before the others have their name, and after.
    for leaves in (lambda old: group.rename(old), lambda old: old.mkdir()):
        leaves(fields / f".{key}.old")
        (fields / f".{key}.1.part").mkdir()
        _sweep._settle_zarr(tmp_path, {key})
        assert kept() == [2, 2, 2]


def test_failed_runs_can_be_done_once_more(tmp_path, monkeypatch):
    """Catches a run that stays failed for good, and one that went well and is done again."""
    monkeypatch.setenv("MYXO_TEST_MARK", str(tmp_path / "mark"))
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        table = myxo.sweep(ANGLES, fails_at_first, out=tmp_path / "out", executor=threads, **STUDY)
        assert table["error"].notna().tolist() == [True, False, False, False]
        again = myxo.sweep(ANGLES, fails_at_first, out=tmp_path / "out", executor=threads, **STUDY)
        assert again["error"].notna().tolist() == [True, False, False, False]
        kept = again["seconds"][1:].tolist()
        again = myxo.sweep(ANGLES, fails_at_first, out=tmp_path / "out", executor=threads, retry=True, **STUDY)
    assert again["error"].isna().all() and again["seconds"][1:].tolist() == kept
    assert again["nothing"].isna().all()


def test_an_error_ends_the_jobs_that_wait(tmp_path, monkeypatch):
    """Catches an executor that does thousands of runs whose results nobody takes."""
    monkeypatch.setenv("MYXO_TEST_MARK", str(tmp_path / "mark"))
    points = [{"trail.decay": 0.9 + number / 1000} for number in range(50)]
    (tmp_path / "out" / "runs").mkdir(parents=True)
    begun = []

    class Counting(concurrent.futures.ThreadPoolExecutor):
        def submit(self, function, *arguments):
            def counted():
                begun.append(1)
                return function(*arguments)

            return super().submit(counted)

    def bar(*_):
        raise RuntimeError("stop")

    monkeypatch.setattr("myxo._sweep._Progress.step", bar)
    with Counting(1) as threads, pytest.raises(RuntimeError, match="stop"):
        myxo.sweep(points, out=tmp_path / "out", executor=threads, **{**STUDY, "progress": True})
    assert len(begun) < 5


def test_a_study_that_changes_is_another_one(tmp_path):
    """Catches rows of another preset or mesh that count as done, and points that are one row."""
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])

    def study(vertices, preset):
        scene = myxo.Scene({"particles.count": 100, "atlas.size": 64}, preset=preset)
        scene.add("corner", (vertices, faces))
        with concurrent.futures.ThreadPoolExecutor(1) as threads:
            return myxo.sweep([{}], out=tmp_path, scene=scene, steps=1, executor=threads, progress=False)

    assert len(study(corner, "network")) == 1
    with pytest.raises(ValueError, match="another study: its scene is"):
        study(corner, "lace")
    with pytest.raises(ValueError, match="another study: its scene is"):
        study(corner + corner[1], "network")
    for seeds in (0, [1, 1], [-1], [2**32]):
        with pytest.raises(ValueError, match="seeds are"):
            myxo.sweep([{}], out=tmp_path / "b", seeds=seeds, **STUDY)
    with pytest.raises(ValueError, match="two points"):
        myxo.sweep({"trail.decay": [0.9, 0.9]}, out=tmp_path / "b", **STUDY)
    with pytest.raises(ValueError, match="two points"):
        myxo.sweep({"trail.decay": [1, 1.0]}, out=tmp_path / "b", **STUDY)
    with pytest.raises(KeyError, match="use `seeds`"):
        myxo.sweep({"seed": [1, 2]}, out=tmp_path / "b", **STUDY)


def test_what_is_bound_to_a_run_is_a_part_of_the_study(tmp_path):
    point = {"trail.decay": [0.9]}
    half, third = (functools.partial(scaled, factor=factor) for factor in (0.5, 0.25))
    first = myxo.sweep(point, half, out=tmp_path, **STUDY)
    assert first["scaled"][0] == pytest.approx(0.45)
    with pytest.raises(ValueError, match="another study: its run is"):
        myxo.sweep(point, third, out=tmp_path, **STUDY)
    with pytest.raises(TypeError, match="not a \\w*Path"):
        myxo.sweep(point, functools.partial(scaled, factor=tmp_path), out=tmp_path, **STUDY)
    # Functions that are bound have the same name in every process.
    bound = [_name_of(functools.partial(scaled, factor=function)) for function in (beginning, beginning, names)]
    assert bound[0] == bound[1] != bound[2] and "0x" not in bound[0]
    with pytest.raises(TypeError, match="not a Scaled"):
        myxo.sweep(point, Scaled(), out=tmp_path, **STUDY)


def test_results_do_not_replace_columns_of_the_table(tmp_path):
    for name in ("error", "seconds", "seed", "trail.decay", "length"):
        run = functools.partial(names, name=name)
        table = myxo.sweep({"trail.decay": [0.9]}, run, out=tmp_path / name, **STUDY)
        assert f"`{name}`, which the table has already" in table["error"][0]
        assert table["seed"][0] == 0 and table["trail.decay"][0] == 0.9


def test_a_study_is_the_same_from_another_folder(tmp_path, monkeypatch):
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "look.toml").write_text("[trail]\ndecay = 0.91\n")
    study = {**STUDY, "out": tmp_path / "out"}
    monkeypatch.chdir(tmp_path)
    one = myxo.sweep({"physarum.speed": [0.004]}, preset="inner/look.toml", **study)
    monkeypatch.chdir(tmp_path / "inner")
    other = myxo.sweep({"physarum.speed": [0.004]}, preset="look.toml", **study)
    assert hashes(one) == hashes(other)
    assert list(one["key"]) == list(other["key"])


def test_a_file_that_a_point_names_is_a_part_of_its_runs(tmp_path):
    """Would catch: rows of another mesh that count as done, because its path is the same."""
    mesh = tmp_path / "corner.obj"

    def sweep(height, executor):
        mesh.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 {height}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        points = {"object.0.mesh": [str(mesh), "builtin:cube"]}
        return myxo.sweep(points, out=tmp_path / "out", executor=executor, **STUDY)

    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        before = sweep(1, threads)
        assert before["error"].isna().all()
        # Nothing is to be done.
        assert hashes(sweep(1, object())) == hashes(before)
        after = sweep(2, threads)
    assert (after["key"] == before["key"]).tolist() == [False, True]
    assert (after["state_hash"] == before["state_hash"]).tolist() == [False, True]
    # A point may have an object's keys as a table; and keys of points without files are as they were.
    contents = json.loads(myxo._myxo.contents(json.dumps([{"object.0": {"mesh": str(mesh)}}, {"trail.decay": 0.9}])))
    assert list(contents[0]) == ["object.0.mesh"] and contents[1] == {}


def test_pictures_of_maps_go_to_other_machines(tmp_path):
    """Catches runs that look for a map in a file of the machine on which the sweep began."""
    from myxo import _scene

    class Elsewhere(concurrent.futures.ThreadPoolExecutor):
        def submit(self, function, job):
            def run():
                if _scene._pictures is not None:
                    _scene._pictures.cleanup()
                    _scene._pictures = None
                return function(pickle.loads(pickle.dumps(job)))

            return super().submit(run)

    # Attracts on one half, by its green.
    area = np.zeros((32, 32, 3))
    area[:, 16:, 1] = 1.0
    study = {**STUDY, "settings": {**SETTINGS, "areas.map": area}}
    # As many processes as without it.
    job = {"device": None, "scene": "cube", "preset": None, "point": {}, "settings": SETTINGS}
    counted = [myxo._sweep._processes([{**job, "settings": s}]) for s in (SETTINGS, study["settings"])]
    assert counted[0] == counted[1]
    with Elsewhere(1) as executor:
        table = myxo.sweep(ANGLES, out=tmp_path, executor=executor, **study)
        assert table["error"].isna().all() and len(table) == 4
        # It is the same study, though the file is another one.
        again = myxo.sweep(ANGLES, out=tmp_path, executor=executor, **study)
    assert hashes(again) == hashes(table)
    with concurrent.futures.ThreadPoolExecutor(1) as threads, pytest.raises(ValueError, match="another study"):
        myxo.sweep(ANGLES, out=tmp_path, executor=threads, **{**study, "settings": {**SETTINGS, "areas.map": area[:, ::-1]}})


def test_numbers_of_points_are_those_of_now(tmp_path):
    """Catches two points with one number after a study has grown, and rows of points that it has no more."""
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        myxo.sweep(ANGLES, out=tmp_path, executor=threads, **STUDY)
        more = {"physarum.sensor_angle": [15.0, 30.0], "trail.decay": [0.9, 0.95, 0.97]}
        table = myxo.sweep(more, out=tmp_path, executor=threads, **STUDY)
        assert table["run"].tolist() == list(range(6))
        assert table["trail.decay"].tolist() == [0.9, 0.95, 0.97] * 2
        fewer = myxo.sweep({key: values[:1] for key, values in ANGLES.items()}, out=tmp_path, executor=threads, **STUDY)
    assert len(fewer) == len(myxo.read_sweep(tmp_path)) == 1


def test_a_full_disk_ends_a_sweep_and_loses_nothing(tmp_path):
    """Catches half a file under its name, and arrays without a row."""
    import resource

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with concurrent.futures.ThreadPoolExecutor(1) as threads, pytest.raises(OSError, match="limit of file sizes"):
            myxo.sweep(ANGLES, out=tmp_path, executor=threads, fields=("particles",), **STUDY)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not list(tmp_path.glob("runs/*.json")) and not list(tmp_path.glob("fields/*"))
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        table = myxo.sweep(ANGLES, out=tmp_path, executor=threads, fields=("particles",), **STUDY)
    assert len(table) == 4 and table["error"].isna().all()


def test_without_a_device_there_is_one_sentence(tmp_path):
    """Catches a study whose every row says that there is no device."""
    code = "import myxo\nmyxo.sweep({'trail.decay': [0.9]}, out='out', scene='cube', steps=1)\n"
    environment = {**os.environ, "VK_DRIVER_FILES": "/nowhere.json", "VK_ICD_FILENAMES": "/nowhere.json"}
    ended = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert ended.returncode == 1 and "Traceback" in ended.stderr
    last = ended.stderr.strip().splitlines()[-1]
    assert last.startswith("myxo.DeviceError: ") and not list(tmp_path.glob("out/runs/*"))
