"""Durable state: kept whole or refused, and a boot number that only grows."""

import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from host.store import (
    Durable,
    FileStore,
    MemoryStore,
    NotCommissioned,
    PartyStore,
    commission,
    commissioned,
    raise_epoch,
)
from network.errors import InputError


def test_file_store_keeps_what_it_was_given(tmp_path: Path) -> None:
    store = FileStore(tmp_path / "durable")
    assert store.load() == Durable()
    durable = Durable(4, b"tokens", b"units")
    store.save(durable)
    assert FileStore(tmp_path / "durable").load() == durable
    assert [path.name for path in tmp_path.iterdir()] == ["durable"]


def test_it_is_on_the_disk_before_it_takes_the_place_of_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The whole file is synced while the old one is in place, the directory when the new one is."""
    path, fsync = tmp_path / "durable", os.fsync
    store = FileStore(path)
    store.save(Durable(1))
    synced: list[tuple[bool, int, int]] = []

    def seen(descriptor: int) -> None:
        found = os.fstat(descriptor)
        synced.append((stat.S_ISDIR(found.st_mode), found.st_size, FileStore(path).load().epoch))
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", seen)
    store.save(Durable(2, b"tokens"))
    file, directory = synced
    assert file == (False, path.stat().st_size, 1)
    assert (directory[0], directory[2]) == (True, 2)


@pytest.mark.parametrize("on_disk", [False, True])
def test_every_boot_is_kept_before_anything_is_said_under_it(tmp_path: Path, on_disk: bool) -> None:
    store: PartyStore = FileStore(tmp_path / "durable") if on_disk else MemoryStore()
    for epoch in (1, 2, 3):
        assert raise_epoch(store).epoch == epoch
        assert store.load().epoch == epoch


def test_what_was_kept_besides_outlives_a_boot(tmp_path: Path) -> None:
    store = FileStore(tmp_path / "durable")
    store.save(Durable(1, b"tokens", None))
    assert raise_epoch(store) == Durable(2, b"tokens", None) == store.load()


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[:3],
        lambda data: b"x" + data[1:],
        lambda data: data[:20] + b"x" + data[21:],
        lambda data: data[:23],
    ],
)
def test_a_damaged_file_is_refused_and_never_taken_for_a_first_start(
    tmp_path: Path, damage: Callable[[bytes], bytes]
) -> None:
    path = tmp_path / "durable"
    FileStore(path).save(Durable(4))
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(InputError, match="undamaged"):
        raise_epoch(FileStore(path))


@pytest.mark.parametrize("damage", [lambda data: data[:-1], lambda data: data[:-1] + b"x"])
def test_a_damaged_spare_is_a_lost_one(tmp_path: Path, damage: Callable[[bytes], bytes]) -> None:
    path = tmp_path / "durable"
    FileStore(path).save(Durable(4, spare=b"units"))
    path.write_bytes(damage(path.read_bytes()))
    assert FileStore(path).load() == Durable(4, spare=None)


@pytest.mark.parametrize("on_disk", [False, True])
def test_a_store_is_blank_until_people_commission_it(tmp_path: Path, on_disk: bool) -> None:
    store: PartyStore = FileStore(tmp_path / "durable") if on_disk else MemoryStore()
    with pytest.raises(NotCommissioned, match="people must commission it"):
        commissioned(store, "point terminal t")
    commission(store)
    assert raise_epoch(commissioned(store, "point terminal t")).epoch == 1


def test_commissioned_again_its_boots_begin_beyond_all_before_and_what_it_kept_is_lost() -> None:
    store = MemoryStore()
    commission(store)
    for _ in range(300):
        last = raise_epoch(store)
    again = MemoryStore()
    commission(again, 2, b"tokens")
    first = raise_epoch(again)
    assert first.epoch > last.epoch
    assert (first.vital, first.spare) == (b"tokens", None)
