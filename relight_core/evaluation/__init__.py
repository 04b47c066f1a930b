"""Metrics and reports on held-out heads and lights."""
