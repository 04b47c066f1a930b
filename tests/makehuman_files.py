"""Files as a MakeHuman archive has them."""


def quad_proxy(offset_z: float, material: dict[str, str]) -> dict:
    """A proxy's JSON: one textured quad on the first four vertices of the base mesh."""
    return {
        "ref_vIdxs": [[0, 1, 2], [1, 2, 3], [2, 3, 0], [3, 0, 1]],
        "weights": [[1, 0, 0]] * 4,
        "offsets": [[0, 0, offset_z]] * 4,
        "uvs": [[0, 0, 1, 0, 1, 1, 0, 1]],
        "faces": [11, 0, 1, 2, 3, 0, 0, 1, 2, 3],
        "materials": [material],
    }
