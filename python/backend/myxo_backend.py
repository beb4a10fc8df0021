"""Builds the package by maturin, after a look at what the machine lacks for that."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import maturin
from maturin import (  # noqa: F401
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

SETUP = Path(__file__).parents[2] / ".ci" / "setup"


def check() -> None:
    """Ends the build with the names of what is missing; on other systems than Linux the compiler says it."""
    if sys.platform == "linux" and SETUP.exists() and subprocess.run([SETUP, "package"]).returncode != 0:
        raise SystemExit("myxo cannot be built: the lines above say what is missing, and how to get it")


def build_wheel(*arguments: Any, **named: Any) -> str:
    """As maturin's."""
    check()
    name: str = maturin.build_wheel(*arguments, **named)
    return name


def build_editable(*arguments: Any, **named: Any) -> str:
    """As maturin's."""
    check()
    name: str = maturin.build_editable(*arguments, **named)
    return name
