"""The networks, as torch modules, and their file of weights."""
