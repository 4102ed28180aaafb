"""`branchline serve` before it serves: what it refuses, and where it listens."""

from collections.abc import Callable
from typing import Any

import pytest

from console.access import LOOPBACK
from console.server import listening_on
from network.errors import InputError


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("no_such_scenario",), "no_such_scenario"),
        (("karasuyama_weekday", "--listen", LOOPBACK), "--tokens"),
        (("karasuyama_weekday", "--tokens", "tokens.json"), "--tokens"),
        (("karasuyama_weekday", "--port", "70000"), "--port"),
        (("karasuyama_weekday", "--beside", "karasuyama_weekday"), "--beside"),
    ],
)
def test_what_cannot_be_served_is_refused(
    main: Callable[..., Any], arguments: tuple[str, ...], said: str
) -> None:
    pytest.importorskip("starlette", reason="the extra [console] is not installed")
    pytest.importorskip("uvicorn", reason="the extra [console] is not installed")
    ended = main("serve", *arguments)
    assert ended.code == 2
    assert said in ended.err


def test_a_port_that_is_taken_is_named() -> None:
    with listening_on(LOOPBACK, 0) as taken:
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"'{LOOPBACK}:{port}'; expected an address and port"):
            listening_on(LOOPBACK, port)
