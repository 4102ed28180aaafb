"""Which services run on a day: the weekdays of `calendar.txt` with the exceptions of `calendar_dates.txt`."""

from __future__ import annotations

import calendar
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from exchange.gtfs.tables import Feed
from exchange.published import some_names
from network.errors import COMMAND_LINE, InputError

WEEKDAYS: Final = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
_DATE: Final = re.compile(r"(\d{4})-?(\d{2})-?(\d{2})")
_SHOWN_MAX: Final = 20  # services named in a message


@dataclass(slots=True)
class _Service:
    """Its weekdays and dates; `added` and `removed` are exceptions. Dates are whole numbers, YYYYMMDD."""

    weekdays: tuple[bool, ...] = ()
    first: int = 0
    last: int = 0
    added: set[int] = field(default_factory=set[int])
    removed: set[int] = field(default_factory=set[int])

    def runs_on(self, date: int) -> bool:
        """Whether it runs on a date."""
        if date in self.added:
            return True
        if date in self.removed or not self.weekdays or not self.first <= date <= self.last:
            return False
        return self.weekdays[calendar.weekday(date // 10_000, date // 100 % 100, date % 100)]


@dataclass(frozen=True, slots=True)
class Services:
    """The services of a feed by id."""

    by_id: Mapping[str, _Service]

    def running_on(self, date: int) -> frozenset[str]:
        """Ids of the services that run on a date, YYYYMMDD."""
        return frozenset(name for name, service in self.by_id.items() if service.runs_on(date))


def read_services(feed: Feed) -> Services:
    """Read both tables, of which a feed has one at least. Raises InputError."""
    services: dict[str, _Service] = {}
    if not feed.has_table("calendar.txt") and not feed.has_table("calendar_dates.txt"):
        raise InputError(str(feed.path), "calendar.txt", None, "this table, or calendar_dates.txt")
    if feed.has_table("calendar.txt"):
        file = f"{feed.path}: calendar.txt"
        for row in feed.rows("calendar.txt", ("service_id", *WEEKDAYS, "start_date", "end_date")):
            name, *days, first, last = row.texts
            key = f"line {row.line}"
            if name in services:
                raise InputError(file, f"{key}.service_id", name, "an id of its own")
            for day, text in zip(WEEKDAYS, days, strict=True):
                if text not in ("0", "1"):
                    raise InputError(file, f"{key}.{day}", text, "0 or 1")
            services[name] = _Service(
                tuple(text == "1" for text in days),
                date_of(file, f"{key}.start_date", first),
                date_of(file, f"{key}.end_date", last),
            )
    if feed.has_table("calendar_dates.txt"):
        file = f"{feed.path}: calendar_dates.txt"
        for row in feed.rows("calendar_dates.txt", ("service_id", "date", "exception_type")):
            name, date, kind = row.texts
            if kind not in ("1", "2"):
                raise InputError(file, f"line {row.line}.exception_type", kind, "1 (added) or 2 (removed)")
            service = services.setdefault(name, _Service())
            on = date_of(file, f"line {row.line}.date", date)
            (service.added if kind == "1" else service.removed).add(on)
    return Services(services)


def date_of(file: str, key: str, text: str) -> int:
    """A date YYYYMMDD or YYYY-MM-DD as a whole number. Raises InputError for what is none."""
    match = _DATE.fullmatch(text)
    if match is not None:
        year, month, day = (int(part) for part in match.groups())
        if year >= 1900 and 1 <= month <= 12 and 1 <= day <= calendar.monthrange(year, month)[1]:
            return year * 10_000 + month * 100 + day
    raise InputError(file, key, text, "a date YYYYMMDD")


def next_date(date: int) -> int:
    """The date after, YYYYMMDD."""
    year, month, day = date // 10_000, date // 100 % 100, date % 100
    if day < calendar.monthrange(year, month)[1]:
        return date + 1
    return (year * 100 + month + 1) * 100 + 1 if month < 12 else (year + 1) * 10_000 + 101


def one_service(trips_of: Mapping[str, int]) -> str:
    """The service that is meant where nobody names one or a date; InputError where there are several."""
    if len(trips_of) == 1:
        return next(iter(trips_of))
    most = sorted(trips_of.items(), key=lambda item: (-item[1], item[0]))
    shown = some_names([f"{name} ({count} trips)" for name, count in most], _SHOWN_MAX)
    raise InputError(COMMAND_LINE, "--service", None, f"a service, or --date YYYY-MM-DD; there are: {shown}")
