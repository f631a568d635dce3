"""Access control: only pages from this server, opened with the token, may use it."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from http.cookies import CookieError, SimpleCookie
from typing import Final

CONTENT_SECURITY_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
    "require-trusted-types-for 'script'"
)
HEADERS: Final = {
    "content-security-policy": CONTENT_SECURITY_POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-cache",
}
SITES: Final = ("same-origin", "none")


class Guard:
    """Checks of the headers of a request."""

    def __init__(self, port: int) -> None:
        self.token = secrets.token_urlsafe(24)
        # A cookie belongs to a host, not to a port: two servers need two names.
        self.cookie = f"hertzchain-{port}"
        # Other hosts would allow DNS rebinding.
        self.hosts = frozenset({f"127.0.0.1:{port}", f"localhost:{port}"})
        self.origins = frozenset(f"http://{host}" for host in self.hosts)

    def refusal(self, headers: Mapping[str, str], *, api: bool) -> str:
        """Reason why a request is rejected; empty if it is accepted."""
        if headers.get("host", "") not in self.hosts:
            return "unknown host"
        origin = headers.get("origin")
        if origin is not None and origin not in self.origins:
            return "unknown origin"
        # Other sites may link to the page, but must not start computations.
        if api and headers.get("sec-fetch-site", "none") not in SITES:
            return "request of another site"
        if not self.has_cookie(headers):
            return "no token: open the address that `hertzchain app` has printed"
        return ""

    def has_cookie(self, headers: Mapping[str, str]) -> bool:
        """Whether the request has the cookie with the token."""
        try:
            morsel = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            return False
        return morsel is not None and self.is_token(morsel.value)

    def is_token(self, given: str) -> bool:
        """Whether a text is the token."""
        return secrets.compare_digest(given.encode(), self.token.encode())

    @property
    def set_cookie(self) -> str:
        """Header that stores the token in the browser."""
        return f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
