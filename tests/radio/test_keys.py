"""Key derivation against the published vectors of RFC 5869 and RFC 4231."""

import pytest

from radio.keys import capability_key, capability_mac, hkdf, key_ring, mac, mac_equal, pair_key

MASTER = bytes(range(32))


def test_hkdf_rfc_5869_case_1() -> None:
    okm = hkdf(b"\x0b" * 22, bytes(range(0xF0, 0xFA)), 42, salt=bytes(range(13)))
    assert okm.hex() == (
        "3cb25f25faacd57a90434f64d0362f2a2d2d0a90cf1a5a4c5db02d56ecc4c5bf34007208d5b887185865"
    )


def test_hkdf_rfc_5869_case_3_without_salt_and_info() -> None:
    okm = hkdf(b"\x0b" * 22, b"", 42)
    assert okm.hex() == (
        "8da4e775a563c18f715f802a063c5a31b8a11f5c5ee1879ec3454e5f3c738d2d9d201395faa4b61a96c8"
    )


@pytest.mark.parametrize("length", [0, 255 * 32 + 1])
def test_hkdf_refuses_lengths_that_rfc_5869_does_not_define(length: int) -> None:
    with pytest.raises(ValueError, match="expected 1 to 8160"):
        hkdf(MASTER, b"", length)


def test_mac_is_rfc_4231_case_5_cut_to_128_bits() -> None:
    assert mac(b"\x0c" * 20, b"Test With Truncation").hex() == "a3b6167473100ee06e0c796c2955552b"


def test_pair_key_is_the_same_for_both_and_for_nobody_else() -> None:
    assert pair_key(MASTER, "train", "manager") == pair_key(MASTER, "manager", "train")
    keys = {pair_key(MASTER, a, b) for a, b in [("a", "bc"), ("ab", "c"), ("a", "b"), ("b", "c")]}
    assert len(keys | {capability_key(MASTER, "a")}) == 5


def test_a_ring_holds_only_the_owners_keys() -> None:
    ring = key_ring(MASTER, "terminal", ["train-1", "train-2"], ["terminal"])
    assert set(ring.pairs) == {"train-1", "train-2"}
    assert ring.pairs["train-1"] == pair_key(MASTER, "train-1", "terminal")
    assert ring.capabilities == {"terminal": capability_key(MASTER, "terminal")}


def test_a_capability_is_for_one_terminal_section_unit_and_token() -> None:
    key = capability_key(MASTER, "t")
    right = capability_mac(key, "t", "s", "u", 7)
    assert mac_equal(right, capability_mac(key, "t", "s", "u", 7))
    others = [("x", "s", "u", 7), ("t", "x", "u", 7), ("t", "s", "x", 7), ("t", "s", "u", 8)]
    assert not any(mac_equal(right, capability_mac(key, *other)) for other in others)
