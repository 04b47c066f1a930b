"""Angles as the panels show them."""


def wrap_degrees(degrees: float) -> float:
    """The same direction in (-180, 180]."""
    wrapped = degrees % 360.0
    return wrapped - 360.0 if wrapped > 180.0 else wrapped
