"""The notebooks of docs/notebooks: executed, and as pages of the site. `make notebooks` runs the quick ones anew."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Final, cast

import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode

FOLDER: Final = Path(__file__).resolve().parent.parent / "docs/notebooks"
QUICK: Final = ("what-if", "own-sensor")  # committed with what they show; the third runs as long as it says
TIMEOUT_S: Final = 600
# nbformat declares no types of these
_read: Final = cast("Callable[..., NotebookNode]", nbformat.read)
_write: Final = cast("Callable[..., None]", nbformat.write)


def notebook(name: str) -> NotebookNode:
    """A committed notebook."""
    return _read(FOLDER / f"{name}.ipynb", as_version=4)


def execute_notebook(book: NotebookNode, folder: Path) -> None:
    """Run every cell in a kernel that works in `folder`; what cells show is put in. An error of a cell is raised."""
    settings = {"metadata": {"path": str(folder)}}
    NotebookClient(
        book, timeout=TIMEOUT_S, kernel_name="python3", resources=settings, record_timing=False
    ).execute()


def texts_shown(book: NotebookNode) -> list[str]:
    """What each code cell printed and returned, as text; of a picture that it is one."""
    return ["".join(_texts(cell)) for cell in book["cells"] if cell["cell_type"] == "code"]


def page_of_notebook(book: NotebookNode) -> str:
    """A notebook as Markdown, with its pictures inside."""
    parts: list[str] = []
    for cell in book["cells"]:
        if cell["cell_type"] == "markdown":
            parts.append(cell["source"])
            continue
        parts.append(f"```python\n{cell['source']}\n```")
        for output in cell["outputs"]:
            picture = output.get("data", {}).get("image/png")
            if picture is not None:
                data = picture.replace("\n", "")
                parts.append(f"![](data:image/png;base64,{data})")
            else:
                parts.append(f"```text\n{_text(output).rstrip()}\n```")
    return "\n\n".join(parts) + "\n"


def _texts(cell: NotebookNode) -> list[str]:
    return ["a picture" if "image/png" in o.get("data", {}) else _text(o) for o in cell["outputs"]]


def _text(output: NotebookNode) -> str:
    return str(output["text"] if output["output_type"] == "stream" else output["data"]["text/plain"])


def main() -> None:
    """Execute the quick notebooks and write what they show."""
    for name in QUICK:
        book = notebook(name)
        with tempfile.TemporaryDirectory() as folder:
            execute_notebook(book, Path(folder))
        for cell in book["cells"]:
            for output in cell.get("outputs", ()):
                output.get("data", {}).pop("text/html", None)  # the same table as its text
        _write(book, FOLDER / f"{name}.ipynb")


if __name__ == "__main__":
    main()
