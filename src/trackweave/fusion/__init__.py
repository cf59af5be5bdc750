"""Tracks of many sensors become one picture: associated, confirmed, registered and fused."""
