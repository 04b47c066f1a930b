"""relight rigs and relight info."""

import json


def test_rigs_are_listed_for_people_and_programs(relight):
    lines = relight("rigs").out.splitlines()
    record = json.loads(relight("rigs", "--json").out)
    names = [rig["name"] for rig in record["rigs"]]
    assert {"soft-window", "rembrandt", "butterfly", "split", "ring", "golden-hour"} <= set(names)
    assert all(rig["title"] and rig["description"] for rig in record["rigs"])
    for name in names:
        assert any(line.startswith(name) for line in lines)


def test_info_tells_versions_devices_and_graphics(relight):
    record = json.loads(relight("info", "--json").out)
    assert record["packages"]["torch"].startswith("2.")
    assert record["devices"][0] == "cpu"
    assert record["threads"]["torch"] >= 1
    assert record["graphics"]
    assert isinstance(record["weights"], list)
    text = relight("info").out
    assert "torch" in text
    assert "threads" in text
