"""Settings for every test."""

from hypothesis import settings

# Machines differ in speed, and a first call may load a library: no test fails for being slow.
settings.register_profile("relight", deadline=None, max_examples=50)
settings.load_profile("relight")
