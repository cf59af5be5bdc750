"""Tracks as ASTERIX category 062; the format ``asterix`` reads it."""

from trackweave.formats.asterix.writing import track_messages
from trackweave.formats.format import Format

__all__ = ["FORMAT"]

FORMAT = Format(
    name="asterix-062",
    title="ASTERIX category 062, system tracks",
    endings=(".ast",),
    carries="place, velocity, acceleration, height, their accuracies, status, number, age; "
    "most reports' address, callsign, Mode A",
    loses="the date, names of tracks that are no numbers of 16 bits, score, hits, covariances",
    writer=track_messages,
)
