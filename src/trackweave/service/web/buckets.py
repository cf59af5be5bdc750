"""How often somebody may do something: a bucket for each address, filled at a steady rate."""

import ipaddress
import time
from collections import OrderedDict
from collections.abc import Callable

__all__ = ["Buckets"]

_MOST = 10_000
"""As many addresses are remembered; the one not seen for longest is forgotten first."""


class Buckets:
    """Counts what addresses do.

    Parameters
    ----------
    rate
        Times a second in the long run.
    size
        Times at once.
    clock
        Returns seconds that never go back.
    """

    def __init__(
        self, rate: float, size: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._rate, self._size, self._clock = rate, size, clock
        self._found: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def __len__(self) -> int:
        """Return how many addresses are remembered."""
        return len(self._found)

    def wait_s(self, address: str) -> float:
        """Return for how long an address must wait [s], 0 where it may go on; takes nothing."""
        return max(0.0, (1.0 - self._left(_key(address))) / self._rate)

    def take(self, address: str) -> float:
        """Count once; return for how long the address must wait [s], 0 where it may go on."""
        key = _key(address)
        left = self._left(key)
        if left < 1.0:
            return (1.0 - left) / self._rate
        self._found[key] = (left - 1.0, self._clock())
        self._found.move_to_end(key)
        while len(self._found) > _MOST:
            self._found.popitem(last=False)
        return 0.0

    def _left(self, key: str) -> float:
        left, since = self._found.get(key, (self._size, 0.0))
        return min(self._size, left + (self._clock() - since) * self._rate)


def _key(address: str) -> str:
    """Return what an address is counted under: of IPv6 the network that one customer is given."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address[:64]
    if found.version == 4:
        return str(found)
    mapped = found.ipv4_mapped
    return str(mapped) if mapped else str(ipaddress.ip_network((int(found) >> 64 << 64, 64)))
