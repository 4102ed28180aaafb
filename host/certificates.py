"""Certificates for runs whose parties are on several machines: an authority signs one for the simulator and one for
each party, for some hours, and its key is then forgotten. So nobody can add one, and a name means one certificate.

| in the folder | what |
|---|---|
| `authority.pem` | whose word both ends believe |
| `certificate.pem`, `key.pem` | the simulator's |
| `denied` | people's: ids of parties whose certificates count no more, one a line |
| `parties/PARTY/` | the same three files of a party, whose id is the name in its certificate |

All of them can be read by their owner alone. X.509 as in RFC 5280; keys are on the curve P-256.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_pem_private_key,
)
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID, ObjectIdentifier

from host.over_tls import AUTHORITY_FILE, CERTIFICATE_FILE, KEY_FILE
from host.process import write_private
from host.scratch import scratch
from network.errors import InputError

DENIED_FILE: Final = "denied"
PARTIES_FOLDER: Final = "parties"
LIFE_H: Final = 24
NAME_CHARACTERS_MAX: Final = 64  # ub-common-name of RFC 5280
_AUTHORITY_NAME: Final = "branchline authority"  # a party's id has no blank
_SIMULATOR_NAME: Final = "branchline simulator"
_SLOW_CLOCK: Final = timedelta(minutes=5)  # a machine whose clock is behind by less takes it too
_OTHERS_BITS: Final = 0o077
_NAME: Final = re.compile(
    r"([0-9A-Za-z-]{1,63}\.)*(?![0-9]+$)[0-9A-Za-z-]{1,63}"
)  # RFC 1123; 10.0.0.256 is none


def make_certificates(
    folder: Path, party_ids: Iterable[str], address: str, life_h: int = LIFE_H, now: datetime | None = None
) -> None:
    """All files of a run, in a folder that is not there yet: all of them or nothing. They count for hours from `now`.

    `address`: name or number under which parties reach the simulator. Raises InputError.
    """
    if folder.exists():
        raise InputError(
            str(folder), "", None, "a folder that is not there yet: certificates are made together"
        )
    names = tuple(party_ids)
    for name in names:
        if len(name) > NAME_CHARACTERS_MAX:
            raise InputError(
                "party", "id", name, f"at most {NAME_CHARACTERS_MAX} characters, as in a certificate"
            )
    begin = now or datetime.now(UTC)
    issuer = CertificateIssuer(begin - _SLOW_CLOCK, begin + timedelta(hours=life_h))
    try:
        with scratch(f".{folder.name}-", folder.parent) as aside:
            made = aside / "made"
            issuer.issue(made, _SIMULATOR_NAME, ExtendedKeyUsageOID.SERVER_AUTH, address)
            for name in names:
                issuer.issue(made / PARTIES_FOLDER / name, name, ExtendedKeyUsageOID.CLIENT_AUTH)
            made.rename(folder)
    except OSError as error:
        raise InputError(str(folder), "", None, f"a folder that can be made ({error.strerror})") from None


def name_in(folder: Path, now: datetime | None = None) -> str:
    """Who the certificate in a folder says that one is.

    Raises InputError for what the other end would refuse without a word.
    """
    authority = _certificate(folder / AUTHORITY_FILE)
    certificate = _certificate(folder / CERTIFICATE_FILE)
    ours = str(folder / CERTIFICATE_FILE)
    if not _is_signed_by(certificate, authority):
        raise InputError(ours, "", None, f"a certificate by the authority in {folder / AUTHORITY_FILE}")
    begin, end = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    if not is_in_time(begin, end, now or datetime.now(UTC)):
        raise InputError(
            ours, "valid", f"{begin:%F %H:%M} to {end:%F %H:%M} UTC", "a time that has not run out"
        )
    key = folder / KEY_FILE
    if not key.exists() or key.stat().st_mode & _OTHERS_BITS:
        raise InputError(str(key), "", None, "a key that its owner alone can read (mode 0600)")
    if _public(key) != certificate.public_key():
        raise InputError(str(key), "", None, f"the key of {ours}")
    names = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    return str(names[0].value) if names else ""


def is_in_time(begin: datetime, end: datetime, now: datetime) -> bool:
    """Whether a certificate counts now."""
    return begin <= now <= end


def denied_in(folder: Path) -> frozenset[str]:
    """The ids on the deny list; none where there is no such file."""
    file = folder / DENIED_FILE
    try:
        return frozenset(filter(None, map(str.strip, file.read_text("utf-8").splitlines())))
    except FileNotFoundError:
        return frozenset()
    except (OSError, UnicodeDecodeError):
        raise InputError(str(file), "", None, "ids of parties, one a line") from None


class CertificateIssuer:
    """An authority; its key is nowhere but here. All that it signs counts from `begin` to `end`."""

    def __init__(self, begin: datetime, end: datetime) -> None:
        self.begin, self.end = begin, end
        self._key = ec.generate_private_key(ec.SECP256R1())
        self._name = _named(_AUTHORITY_NAME)
        basic = x509.BasicConstraints(ca=True, path_length=0)
        builder = self._begun(self._name, self._key.public_key()).add_extension(basic, critical=True)
        self._own = builder.sign(self._key, SHA256()).public_bytes(Encoding.PEM)

    def issue(self, folder: Path, name: str, use: ObjectIdentifier, address: str = "") -> None:
        """A new key, its certificate, and that of the authority, in a new folder. `address`: where it is found."""
        folder.mkdir(mode=0o700, parents=True)
        key = ec.generate_private_key(ec.SECP256R1())
        builder = self._begun(_named(name), key.public_key())
        builder = builder.add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        builder = builder.add_extension(x509.ExtendedKeyUsage([use]), critical=True)
        if address:
            found_at = x509.SubjectAlternativeName([_general_name(address)])
            builder = builder.add_extension(found_at, critical=False)
        write_private(folder / AUTHORITY_FILE, self._own)
        certificate = builder.sign(self._key, SHA256())
        write_private(folder / CERTIFICATE_FILE, certificate.public_bytes(Encoding.PEM))
        own = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        write_private(folder / KEY_FILE, own)

    def _begun(self, name: x509.Name, key: ec.EllipticCurvePublicKey) -> x509.CertificateBuilder:
        builder = x509.CertificateBuilder(self._name, name, key, x509.random_serial_number())
        return builder.not_valid_before(self.begin).not_valid_after(self.end)


def _named(name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])


def _general_name(address: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(address))
    except ValueError:
        pass
    if _NAME.fullmatch(address) is None:
        expected = "a number or a name: ASCII letters, digits and hyphens between dots"
        raise InputError("command line", "--address", address, expected)
    return x509.DNSName(address)


def _certificate(file: Path) -> x509.Certificate:
    try:
        return x509.load_pem_x509_certificate(file.read_bytes())
    except (OSError, ValueError):
        raise InputError(
            str(file), "", None, "a certificate (PEM), as `branchline certificates` makes"
        ) from None


def _public(key: Path) -> object:
    """What belongs to a private key; None where the file has none."""
    try:
        return load_pem_private_key(key.read_bytes(), None).public_key()
    except (OSError, ValueError, TypeError):
        return None


def _is_signed_by(certificate: x509.Certificate, authority: x509.Certificate) -> bool:
    try:
        certificate.verify_directly_issued_by(authority)
    except (ValueError, TypeError, InvalidSignature):
        return False
    return True
