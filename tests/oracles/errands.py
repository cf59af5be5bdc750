"""Tasks and actors that workers import by name."""

import os
import signal
import time
from pathlib import Path


def square(number: int) -> int:
    return number * number


def late_square(number: int, seconds: float) -> int:
    time.sleep(seconds)
    return number * number


def refuse(number: int) -> int:
    message = f"no {number}\nhere"
    raise ArithmeticError(message)


def process(_: int = 0) -> int:
    return os.getpid()


def nap(marks: Path, seconds: float) -> int:
    """Say which process sleeps, and sleep."""
    (marks / f"{os.getpid()}").touch()
    time.sleep(seconds)
    return os.getpid()


def fall_first(marks: Path, number: int, times: int) -> int:
    """Kill one's own process the first few times, then return as if nothing had been."""
    done = len(list(marks.glob(f"{number}-*")))
    (marks / f"{number}-{done}").touch()
    if done < times:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def hang_first(marks: Path, number: int) -> int:
    """Hang the first time."""
    is_first = not (marks / f"{number}").exists()
    (marks / f"{number}").touch()
    if is_first:
        time.sleep(600.0)
    return number


def unsendable() -> object:
    return lambda: None


class Counter:
    def __init__(self, start: int) -> None:
        self.count = start

    def add(self, number: int) -> int:
        self.count += number
        return self.count

    def process(self) -> int:
        return os.getpid()

    def take(self, content: bytes) -> int:
        return len(content)

    def fall(self) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    def sleep(self, seconds: float) -> None:
        time.sleep(seconds)

    def fail(self) -> None:
        message = "not today"
        raise LookupError(message)
