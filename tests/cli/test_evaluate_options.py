"""`relight evaluate` refuses an option that what it is asked to measure does not read."""

import pytest

from app.cli.main import main


@pytest.mark.parametrize(
    "words",
    [
        ["networks", "--size", "128"],
        ["networks", "--sun", "sun.safetensors"],
        ["--detail", "--quality", "live"],
        ["--detail", "--weights", "w.safetensors"],
        ["breakdown", "--every", "2"],
        ["ablation", "--photos", "camera"],
        ["ablation", "--weights", "w.safetensors"],
        ["peers", "--quality", "live"],
    ],
)
def test_an_option_that_would_change_nothing_is_refused(tmp_path, capfd, words):
    data = ["--heads", str(tmp_path), "--lights", str(tmp_path), "-o", str(tmp_path / "out")]
    assert main(["evaluate", *words, *data]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert f"{words[-2]}: changes nothing" in err
