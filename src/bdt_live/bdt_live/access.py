"""Who may see the page: token, password, cookie, host and origin."""

import hmac
import secrets
from dataclasses import dataclass, field

COOKIE = "bdt_live"
LOOPBACK = ("127.0.0.1", "localhost")


@dataclass(frozen=True)
class Access:
    """What opens the page.

    The token is part of the address that is printed, and is exchanged for a cookie at once, so
    that it does not stay in the address bar. With a password both are needed.

    Attributes
    ----------
    host : str
        Where the server listens.
    port : int
        Its port.
    password : str or None
        None where the page is for this computer alone.
    token, session : str
        Secrets of this server: in the address, and in the cookie.
    """

    host: str
    port: int
    password: str | None = None
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    session: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names by which a browser may call this server, each with the port."""
        names = LOOPBACK if self.host in LOOPBACK else (self.host, *LOOPBACK)
        return tuple(f"{_bracketed(name)}:{self.port}" for name in names)

    @property
    def address(self) -> str:
        """The address that opens the page."""
        return f"http://{self.hosts[0]}/?token={self.token}"

    def is_host(self, given: str | None) -> bool:
        """Tell whether a request is for this server, by its header Host.

        A name that somebody else has pointed to this address is none of this server's.
        """
        return given in self.hosts

    def is_origin(self, given: str | None) -> bool:
        """Tell whether a socket is opened by this server's own page, by its header Origin."""
        return given in {f"http://{host}" for host in self.hosts}

    def is_token(self, given: str) -> bool:
        """Tell whether a token is the token; it takes as long for any text."""
        return _is_same(given, self.token)

    def is_session(self, given: str) -> bool:
        """Tell whether a cookie is the cookie; it takes as long for any text."""
        return _is_same(given, self.session)

    def is_password(self, given: str) -> bool:
        """Tell whether a password is the password; it takes as long for any text."""
        return self.password is not None and _is_same(given, self.password)


def _is_same(given: str, secret: str) -> bool:
    return hmac.compare_digest(given.encode("utf-8", "replace"), secret.encode())


def _bracketed(name: str) -> str:
    return f"[{name}]" if ":" in name else name
