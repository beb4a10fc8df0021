"""The lines of the README run as they stand, but for smaller numbers."""

import re
from pathlib import Path

import myxo

README = Path(__file__).parents[2] / "README.md"
# So that the lines take seconds.
SMALLER = {"particles=200_000": "particles=2_000", "sim.step(400)": "sim.step(4)", "seeds=3,": "seeds=1, steps=4, progress=False,"}


def test_the_lines_of_the_readme_run(tmp_path, monkeypatch, capsys):
    """Catches lines that a new user copies and that do not work."""
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    for line, smaller in SMALLER.items():
        assert code.count(line) == 1, line
        code = code.replace(line, smaller)
    names: dict[str, object] = {}
    exec(compile(code, "README.md", "exec"), names)
    sim, table, image = names["sim"], names["table"], names["image"]
    assert sim.state_hash in capsys.readouterr().out
    assert image.shape == (720, 1280, 4) and len(names["particles"]) == 2_000
    assert len(table) == 3 and table["error"].isna().all() and len(myxo.read_sweep(tmp_path / "angles")) == 3
    sim.close()
