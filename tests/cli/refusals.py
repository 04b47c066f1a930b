"""What a maker's command says of bad input."""


def refused(result, *words):
    code, out, err = result
    assert code == 2
    assert out == ""
    line = err.strip().splitlines()[-1]
    assert line.startswith("relight ")
    assert "Traceback" not in err
    for word in words:
        assert word in line
