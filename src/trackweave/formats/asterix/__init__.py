"""ASTERIX: what air surveillance sensors and trackers send.

``decoding`` makes reports of bytes. ``framing`` finds data blocks in what they come in, with
``packets`` in captures of a network; ``gathering`` collects their records; ``layout`` and
``records`` know what items are made of; one module for each category says which there are, and
what columns become of them. ``writing`` makes category 062 of tracks.
"""

from trackweave.formats.asterix.cat021 import DEFAULT_EDITION, EDITIONS
from trackweave.formats.asterix.decoding import AsterixDecoder, is_asterix
from trackweave.formats.format import Format, Option

__all__ = ["FORMAT"]

FORMAT = Format(
    name="asterix",
    title="ASTERIX 001, 002, 010, 020, 021, 034, 048, 062: raw, final format, pcap, pcapng",
    endings=(".ast", ".raw", ".asterix", ".ff", ".pcap", ".pcapng"),
    carries="position, time, SAC/SIC, height, Mode A, address, callsign, amplitude, Doppler; "
    "a radar's place and turn",
    loses="other items, other categories, fragmented packets",
    recognise=is_asterix,
    decoder=AsterixDecoder,
    options=(Option("edition_021", DEFAULT_EDITION, "edition of category 021", tuple(EDITIONS)),),
)
