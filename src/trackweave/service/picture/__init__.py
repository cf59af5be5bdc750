"""A run as a page of its own, of the same files that a live service serves from ``page/``."""

from trackweave.service.picture.page import page_of_run

__all__ = ["page_of_run"]
