"""Pages from the templates of `study/templates`: text in them is escaped, and a name that nobody gives is an error."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from study.wording.catalogue import phrase


def rendered(template: str, **shown: object) -> str:
    """A template with what it shows, and `phrase` for its own words."""
    return _environment().get_template(template).render(shown, phrase=phrase)


@cache
def _environment() -> Environment:
    """It keeps what it has compiled of a template."""
    return Environment(
        loader=PackageLoader("study", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
