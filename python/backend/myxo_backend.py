"""Builds the package by maturin, after a look at what the machine lacks for that."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import maturin
from maturin import build_sdist, get_requires_for_build_sdist  # noqa: F401

SETUP = Path(__file__).parents[2] / ".ci" / "setup"


def check() -> None:
    """Ends the build with the names of what is missing; on other systems than Linux the compiler says it."""
    if sys.platform == "linux" and SETUP.exists() and subprocess.run([SETUP, "package"]).returncode != 0:
        raise SystemExit("myxo cannot be built: the lines above say what is missing, and how to get it")


def _checked(hook: Callable[..., Any]) -> Callable[..., Any]:
    """A hook of maturin's, after the look."""

    def checked(*arguments: Any, **named: Any) -> Any:
        check()
        return hook(*arguments, **named)

    return checked


# In the order in which they are called: what is missing is said before anything is fetched.
get_requires_for_build_wheel = _checked(maturin.get_requires_for_build_wheel)
get_requires_for_build_editable = _checked(maturin.get_requires_for_build_editable)
prepare_metadata_for_build_wheel = _checked(maturin.prepare_metadata_for_build_wheel)
prepare_metadata_for_build_editable = _checked(maturin.prepare_metadata_for_build_editable)
build_wheel = _checked(maturin.build_wheel)
build_editable = _checked(maturin.build_editable)
