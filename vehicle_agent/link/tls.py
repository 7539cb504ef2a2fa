"""Mutual TLS on the fleet's links: whose certificates are used, and in plain words why one was refused."""

from __future__ import annotations

import socket
import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HANDSHAKE_TIMEOUT_S = 2.0
"""Long enough for a thin radio; who does not answer by then is not there, which is no refusal."""


@dataclass(frozen=True, slots=True)
class TlsFiles:
    """One participant's PEM files.

    Attributes
    ----------
    ca
        Certificate of the authority that signs every participant's.
    certificate, key
        The participant's own.
    """

    ca: Path
    certificate: Path
    key: Path

    @classmethod
    def of(cls, paths: tuple[Path, Path, Path] | None) -> TlsFiles | None:
        return None if paths is None else cls(*paths)

    def trouble(self) -> str | None:
        """Why these files cannot be used, one sentence with the file and the mend; None when they can."""
        for name, path in (("ca", self.ca), ("certificate", self.certificate), ("key", self.key)):
            try:
                path.read_bytes()
            except OSError as error:
                reason = (error.strerror or str(error)).lower()
                return f"{path}: {reason}; correct radio.tls.{name} in the mission file"
        try:
            self.context()
        except ssl.SSLError as error:
            return (
                f"{self.certificate}: is no PEM certificate that fits the key {self.key} and the authority {self.ca} "
                f"({_reason(error)}); correct radio.tls in the mission file"
            )
        return None

    def context(self) -> ssl.SSLContext:
        """A caller's side of these files; names are not compared, membership of the authority is what counts."""
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname = False
        context.load_verify_locations(self.ca)
        context.load_cert_chain(self.certificate, self.key)
        return context

    def profile(self) -> dict[str, Any]:
        """Zenoh's `transport/link/tls`."""
        return {
            "root_ca_certificate": str(self.ca),
            "listen_certificate": str(self.certificate),
            "listen_private_key": str(self.key),
            "connect_certificate": str(self.certificate),
            "connect_private_key": str(self.key),
            "enable_mtls": True,
            "verify_name_on_connect": False,
        }


def refusal(endpoint: str, files: TlsFiles) -> str | None:
    """Shake hands once with an endpoint such as `tls/10.0.0.2:7451`; tell who refused whose certificate.

    Zenoh itself only goes on trying. One sentence with the mend; None when the handshake went well, when nobody is
    there yet, and for endpoints without TLS.
    """
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.partition("#")[0].partition("?")[0].rpartition(":")
    if protocol != "tls" or not port.isdigit():
        return None
    try:
        with (
            socket.create_connection((host.strip("[]"), int(port)), HANDSHAKE_TIMEOUT_S) as plain,
            files.context().wrap_socket(plain) as secured,
        ):
            secured.recv(1)  # TLS 1.3: the other side's refusal comes after our handshake is done
    except ssl.SSLCertVerificationError as error:
        return (
            f"{endpoint}: its certificate is refused here ({error.verify_message}): it is not signed by {files.ca}; "
            "give every participant a certificate of the same authority (radio.tls in the mission file)"
        )
    except ssl.SSLError as error:
        return (
            f"{endpoint}: it refuses the certificate {files.certificate} ({_reason(error)}); have that certificate "
            "signed by the fleet's authority (radio.tls in the mission file)"
        )
    except OSError:  # nobody is there yet, or says nothing: Zenoh goes on trying
        return None
    return None


def _reason(error: ssl.SSLError) -> str:
    return (
        (error.reason or str(error)).lower().replace("_", " ").removeprefix("tlsv1 alert ").removeprefix("sslv3 alert ")
    )
