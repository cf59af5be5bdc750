"""Kalman filtering and smoothing."""
