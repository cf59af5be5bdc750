"""Turns reports of many sensors into tracks of many objects."""
