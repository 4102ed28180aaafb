"""What a command says where a person waits for it."""


def without_waits(stderr: str) -> list[str]:
    """The lines that a command says on any machine: without those that say that it goes on."""
    return [line for line in stderr.splitlines() if not line.endswith(" s so far")]
