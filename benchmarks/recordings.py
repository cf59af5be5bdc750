"""Real recordings, identities hidden, with no configuration and with one made by hand."""

import argparse

from recordings_boxes import kitti, tud
from recordings_data import add_arguments
from recordings_points import autoferry, cells, evening, joyride
from text_tables import command, heading

TABLES = {
    "autoferry": ("Autoferry: a ferry's sensors, two reference vessels", autoferry),
    "tud": ("TUD-Campus: people in a video", tud),
    "kitti": ("KITTI: what a car's laser scanner finds", kitti),
    "cells": ("Cells under a microscope", cells),
    "joyride": ("Joyride: a ship's radar follows a boat", joyride),
    "evening": ("Evening: aircraft at Barcelona's radar, four hours", evening),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.add_argument("--only", nargs="+", choices=list(TABLES), default=list(TABLES))
    arguments = parser.parse_args()
    if not arguments.recordings.is_dir():
        print(f"Skipped: {arguments.recordings} is not there; name a folder with --recordings")
        return
    print(heading(command("recordings.py")))
    for name in arguments.only:
        title, run = TABLES[name]
        print(f"\n### {title}\n\n{run(arguments.recordings)}", flush=True)


if __name__ == "__main__":
    main()
