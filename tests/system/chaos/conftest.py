"""Nets of drawn lines, built once for all tests of this folder."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def nets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where nets are kept."""
    return tmp_path_factory.mktemp("nets")
