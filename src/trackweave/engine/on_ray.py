"""Workers that Ray places; the only module that imports Ray."""

import os
import socket
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from importlib.metadata import version
from typing import Any

import ray

if not hasattr(ray, "init"):
    message = "a folder called ray, which is none"
    raise ModuleNotFoundError(message, name="ray")

from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from trackweave.engine.protocol import Death, EngineError, Worker
from trackweave.engine.serving import Served

__all__ = ["RayHost"]

HEAD_PORT = 6379
"""Where the head of a cluster listens, unless told otherwise."""
PATIENCE_S = 5.0
"""So long its machine may take to answer [s]."""
STARTING_S = 60.0
"""So long a machine may take to start a first worker [s]."""
MOST_LINES = 6
"""Lines of Ray's errors that are told: of two versions, both."""
FULL = (ray.exceptions.ObjectStoreFullError, ray.exceptions.OutOfDiskError)
"""What Ray raises where neither its store nor the disk that it is moved to has room."""


def _address_of_head(name: str) -> str:
    """Return where Ray finds the head, which answers at once or not at all; Ray takes a minute."""
    host, _, port = name.removeprefix("ray://").partition(":")
    try:
        number = int(port or HEAD_PORT)
        socket.create_connection((host, number), timeout=PATIENCE_S).close()
    except (OSError, ValueError, OverflowError) as err:
        raise EngineError(
            f"engine: {name:.80} cannot be reached ({err}); expected ray://HOST or "
            f"ray://HOST:PORT, where `ray start --head --port {HEAD_PORT}` runs"
        ) from err
    return f"{host}:{number}"


def _in_a_line(err: Exception) -> str:
    """Return what an error says first, as one line, without advice and trace."""
    first = str(err).strip().partition("\n\n")[0].splitlines()
    return " ".join(each.strip() for each in first[:MOST_LINES])


def _own_version() -> str:
    """Return which trackweave this process has."""
    return version("trackweave")


def _require_alike(name: str) -> None:
    """Refuse a cluster with machines that have another trackweave, or none."""
    # Others' results may differ without a word, and which machine does what nobody can tell.
    ours, asked = _own_version(), dict[str, Any]()
    nodes: Any = ray.nodes
    for each in nodes():
        # A head without processors gets no work.
        if each["Alive"] and each["Resources"].get("CPU", 0) >= 1:
            there = NodeAffinitySchedulingStrategy(each["NodeID"], soft=False)
            options: dict[str, Any] = {"num_cpus": 0, "scheduling_strategy": there}
            asking: Any = ray.remote(**options)(_own_version)
            asked[each["NodeManagerAddress"]] = asking.remote()
    for machine, sign in asked.items():
        try:
            theirs = f"trackweave {ray.get(sign, timeout=STARTING_S)}"
        except (ray.exceptions.TaskUnschedulableError, ray.exceptions.NodeDiedError):
            continue
        except ray.exceptions.RayError as err:
            theirs = f"no trackweave that starts ({_in_a_line(err)})"
        if theirs != f"trackweave {ours}":
            raise EngineError(
                f"engine: {name}: its machine {machine} has {theirs}; expected trackweave "
                f"{ours} as here, on all machines"
            )


def _quieten() -> None:
    """Keep Ray from telling of dead workers on standard output, where results go."""
    # It has no setting for that. Where later versions have another name for it, they tell.
    within: Any = import_module("ray._private.worker")
    if hasattr(within, "print_to_stdstream"):
        within.print_to_stdstream = lambda *_, **__: None


_OPEN: list["RayHost"] = []
"""Those who use the connection that the first of them made; none where others had made one."""


class RayHost:
    """Brings Ray's actors, one for each worker: each a process that lives until it is ended."""

    def __init__(self, name: str, workers: int) -> None:
        if ray.is_initialized():
            # Whoever connected before decides where; the last of ours that is closed disconnects.
            _OPEN.extend([self] if _OPEN else [])
            return
        _OPEN.clear()
        _quieten()
        quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR"}
        try:
            if name == "ray":
                # Ray tells its makers of its use unless told otherwise. Workers import what the
                # caller can.
                os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
                path = {"env_vars": {"PYTHONPATH": os.pathsep.join(sys.path)}}
                ray.init(
                    "local", num_cpus=workers, include_dashboard=False, runtime_env=path,
                    _node_ip_address="127.0.0.1", **quiet,
                )  # fmt: skip
            else:
                ray.init(_address_of_head(name), **quiet)
        except EngineError:
            raise
        except Exception as err:
            # Unreachable, of another version, no room: Ray raises whatever its parts raise.
            told = _in_a_line(err)
            raise EngineError(
                f"engine: {name} does not answer ({type(err).__name__}: {told}); expected a head "
                "of Ray in the same version, started by `ray start --head`, which takes the token "
                "given here if it asks for one; or the engine local"
            ) from err
        _OPEN.append(self)
        try:
            if name != "ray":
                _require_alike(name)
        except EngineError:
            self.close()
            raise

    def hire(self) -> "_Placed":
        """Return a new worker, which Ray has yet to place."""
        return _Placed()

    def wait(
        self, workers: Sequence[Worker], seconds: float | None
    ) -> list[tuple[Worker, bytes | Death]]:
        """Return replies and deaths as soon as there are any, nothing when the time is over."""
        placed = [each for each in workers if isinstance(each, _Placed)]
        owner = {sign: each for each in placed for sign in each.signs}
        if not owner:
            return []
        ready, _ = ray.wait(list(owner), num_returns=1, timeout=seconds)
        if ready:
            ready, _ = ray.wait(list(owner), num_returns=len(owner), timeout=0)
        # A reply that was sent before the worker died still counts.
        first: dict[_Placed, Any] = {}
        for sign in (each for each in owner if each in set(ready)):
            first.setdefault(owner[sign], sign)
        return [(worker, worker.heard(sign)) for worker, sign in first.items()]

    def close(self) -> None:
        """Leave Ray where this engine or one beside it joined it."""
        if self in _OPEN:
            _OPEN.remove(self)
            if not _OPEN:
                ray.shutdown()


class _Room:
    """A worker's own side: calls in one thread, and in the other a wait that only death ends."""

    def __init__(self) -> None:
        self._served = Served()

    def serve(self, call: bytes) -> bytes:
        return self._served.reply(call)

    def live(self) -> None:
        threading.Event().wait()


class _Placed:
    """A worker somewhere in the cluster."""

    def __init__(self) -> None:
        # Ray's types know only some of its options.
        options: dict[str, Any] = {"num_cpus": 1, "max_restarts": 0, "max_concurrency": 2}
        room: Any = ray.remote(**options)(_Room)
        self._room: Any = room.remote()
        self._life = self._room.live.remote()
        self._replies: list[Any] = []

    @property
    def signs(self) -> list[Any]:
        """What becomes ready when a reply comes or the worker dies; replies in order."""
        return [*self._replies[:1], self._life]

    def send(self, call: bytes) -> None:
        """Send a call; a dead worker says nothing, and is found by the wait that it ends."""
        try:
            self._replies.append(self._room.serve.remote(call))
        except FULL as err:
            raise EngineError(
                f"engine: no room for a task of {len(call) / 1e6:,.0f} MB: Ray's object store and "
                "the disk behind it are full here; expected some more of either"
            ) from err

    def heard(self, sign: Any) -> bytes | Death:
        """Return the reply that is there, or why there will be none."""
        try:
            reply: bytes = ray.get(sign)
        except FULL:
            return Death("had no room for its reply: Ray's object store and its disk are full")
        except ray.exceptions.RayError as err:
            return Death(f"was lost ({type(err).__name__}: {_in_a_line(err)})")
        self._replies.pop(0)
        return reply

    def kill(self) -> None:
        """End it at once, whatever it does."""
        with suppress(ray.exceptions.RayError):
            ray.kill(self._room, no_restart=True)
