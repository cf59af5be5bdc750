"""``python -m trackweave``."""

from trackweave.cli import main

if __name__ == "__main__":
    main()
