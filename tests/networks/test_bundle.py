"""Weights on disk: what comes back, and what is refused."""

import json

import pytest
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from relight_core.errors import InputError
from relight_core.networks import bundle as bundle_module
from relight_core.networks.blocks import fold_normalisation
from relight_core.networks.bundle import (
    BundleConfig,
    NetworkBundle,
    load_bundle,
    save_bundle,
    with_detail_pass,
    with_narrow_pair,
    with_person_network,
)
from relight_core.networks.composition import CompositionConfig
from relight_core.networks.delight import DelightConfig
from relight_core.networks.pair import PairConfig, RelightingPair
from relight_core.networks.person import PersonConfig, PersonNetwork
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork
from relight_core.networks.tensor_file import checksum


@pytest.fixture
def bundle():
    torch.manual_seed(1)
    return NetworkBundle(BundleConfig.tiny())


def test_whole_precision_comes_back_exactly(bundle, tmp_path):
    bundle.card = {"steps": "120", "scores": "none"}
    save_bundle(tmp_path / "w.safetensors", bundle, half=False)
    loaded = load_bundle(tmp_path / "w.safetensors")
    assert loaded.config == bundle.config
    assert loaded.card == {"steps": "120", "scores": "none"}
    for name, value in bundle.state_dict().items():
        torch.testing.assert_close(loaded.state_dict()[name], value, rtol=0, atol=0)


def test_equal_weights_make_equal_files(bundle, tmp_path):
    bundle.card = dict.fromkeys(("widths", "data", "steps", "scores", "licence – CC0"), "said of them")
    files = [tmp_path / f"{number}.safetensors" for number in range(4)]
    for path in files:
        save_bundle(path, bundle)
    assert len({path.read_bytes() for path in files}) == 1
    assert load_bundle(files[0]).card == bundle.card


def test_half_precision_comes_back_nearly(bundle, tmp_path):
    save_bundle(tmp_path / "w.safetensors", bundle)
    loaded = load_bundle(tmp_path / "w.safetensors")
    assert all(value.dtype != torch.float16 for value in loaded.state_dict().values())
    for name, value in bundle.state_dict().items():
        torch.testing.assert_close(loaded.state_dict()[name], value, rtol=1e-3, atol=1e-6)


def test_means_and_variances_beyond_half_precision_survive(bundle, tmp_path):
    bundle.delight.encoder.stem.norm.running_var.fill_(1e6)
    bundle.delight.encoder.stem.norm.running_var[0] = 1e-9
    bundle.delight.encoder.stem.norm.running_mean.fill_(1e6)
    save_bundle(tmp_path / "w.safetensors", bundle)
    norm = load_bundle(tmp_path / "w.safetensors").delight.encoder.stem.norm
    assert norm.running_var[1] == norm.running_mean[1] == 1e6
    assert 0 < norm.running_var[0] < 1e-8


def test_another_configuration_travels_with_the_weights(tmp_path):
    config = BundleConfig(DelightConfig(4, 3, anchored=False), *list(vars(BundleConfig.tiny()).values())[1:])
    save_bundle(tmp_path / "w.safetensors", NetworkBundle(config))
    assert load_bundle(tmp_path / "w.safetensors").delight.config.anchored is False


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 7e4])
def test_weights_that_are_not_finite_are_never_saved(bundle, tmp_path, bad):
    """In half precision 7e4 is infinite."""
    path = tmp_path / "w.safetensors"
    save_bundle(path, bundle)
    before = path.read_bytes()
    bundle.composition.head.bias.data[0] = bad
    with pytest.raises(ValueError, match="not finite"):
        save_bundle(path, bundle)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["w.safetensors"]


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="gone.safetensors"):
        load_bundle(tmp_path / "gone.safetensors")


@pytest.mark.parametrize("kept", [0, 7, 300, -100])
def test_damaged_file(bundle, tmp_path, kept):
    path = tmp_path / "w.safetensors"
    save_bundle(path, bundle)
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(InputError, match=r"w\.safetensors"):
        load_bundle(path)


def test_a_folder_and_a_text_are_refused(tmp_path):
    (tmp_path / "text.safetensors").write_text("weights?" * 100)
    for path, why in ((tmp_path, "is a folder; name a file"), (tmp_path / "text.safetensors", "can't be read")):
        with pytest.raises(InputError, match=why):
            load_bundle(path)


def test_a_file_that_is_missing_is_told_without_the_system_s_words(tmp_path):
    with pytest.raises(InputError, match=r"gone\.safetensors: no such file; check the path") as told:
        load_bundle(tmp_path / "gone.safetensors")
    assert "Errno" not in str(told.value)


def rewritten(path, metadata, drop=None):
    tensors = {name: value for name, value in load_file(path).items() if name != drop}
    save_file(tensors, path, metadata=metadata)


@pytest.mark.parametrize(
    "metadata",
    [
        None,
        {"format": "somebody-else's", "config": "{}"},
        {"format": "relight-networks-2", "config": BundleConfig.tiny().to_json()},
        {"format": "relight-networks-1"},
        {"format": "relight-networks-1", "config": "{}"},
        {"format": "relight-networks-1", "config": "not json"},
        {"format": "relight-networks-1", "config": "[]"},
    ],
)
def test_other_formats_and_broken_headers_are_refused(bundle, tmp_path, metadata):
    path = tmp_path / "w.safetensors"
    save_bundle(path, bundle)
    rewritten(path, metadata)
    with pytest.raises(InputError):
        load_bundle(path)


@pytest.mark.parametrize("network", ["delight", "specular_shadow", "composition"])
def test_a_header_of_networks_without_levels_is_refused(bundle, tmp_path, network):
    path, config = tmp_path / "w.safetensors", json.loads(bundle.config.to_json())
    save_bundle(path, bundle)
    config[network]["levels"] = 0
    rewritten(path, {"format": "relight-networks-1", "config": json.dumps(config)})
    with pytest.raises(InputError, match="these weights can't be read"):
        load_bundle(path)


@pytest.mark.parametrize(
    ("field", "number", "why"),
    [
        ("residual", [0, 3, 3_000_000], "3000011 levels and blocks, which .* tensors can't be"),
        ("decoder_residual", [3_000_000, 0], "levels and blocks"),
        ("levels", 30_000_000, "levels and blocks"),
        ("decoder_least", 25_000, "25000 channels, and no tensor has more than 1536"),
        ("detail_width", 25_000, "25000 channels"),
    ],
)
def test_networks_much_larger_than_their_file_are_refused_before_they_are_made(
    bundle, tmp_path, monkeypatch, field, number, why
):
    path, config = tmp_path / "w.safetensors", json.loads(bundle.config.to_json())
    save_bundle(path, bundle)
    config["delight"][field] = number
    rewritten(path, {"format": "relight-networks-1", "config": json.dumps(config)})
    monkeypatch.setattr(bundle_module, "NetworkBundle", lambda config: pytest.fail("made"))
    with pytest.raises(InputError, match=f"these weights can't be read .*{why}"):
        load_bundle(path)


@pytest.mark.parametrize(("levels", "is_refused"), [(2, False), (20, True)])
def test_a_limit_to_channels_that_no_level_comes_near_is_no_size(bundle, tmp_path, levels, is_refused):
    path = tmp_path / "w.safetensors"
    save_bundle(path, with_person_network(bundle, PersonNetwork(PersonConfig(width=4, levels=2, widest=25_000))))
    assert load_bundle(path).config.person.widest == 25_000
    with safe_open(path, framework="pt") as file:
        header = file.metadata()
    config = json.loads(header["config"])
    config["person"]["levels"] = levels
    rewritten(path, {"format": header["format"], "config": json.dumps(config)})
    if is_refused:
        with pytest.raises(InputError, match="25000 channels, and no tensor has more"):
            load_bundle(path)
    else:
        load_bundle(path)


def test_a_missing_tensor_and_other_sizes_are_refused(bundle, tmp_path):
    path = tmp_path / "w.safetensors"
    good = {"format": "relight-networks-1", "config": bundle.config.to_json()}
    save_bundle(path, bundle)
    rewritten(path, good, drop="delight.head.bias")
    with pytest.raises(InputError):
        load_bundle(path)
    save_bundle(path, bundle)
    rewritten(path, good | {"config": BundleConfig().to_json()})
    with pytest.raises(InputError):
        load_bundle(path)


def test_inference_form_computes_the_same(bundle, tmp_path):
    bundle.eval()
    photo = torch.rand(1, 3, 8, 8)
    with torch.no_grad():
        before = bundle.delight(photo).albedo_srgb
    after = bundle.for_inference().delight(photo).albedo_srgb
    torch.testing.assert_close(after, before, rtol=1e-3, atol=1e-4)
    assert not after.requires_grad


def test_rounded_networks_compute_in_bf16_what_the_others_compute_in_fp32():
    torch.manual_seed(0)
    bundle = NetworkBundle(BundleConfig.tiny()).for_inference()
    rounded = bundle.rounded()
    assert rounded is bundle.rounded()
    normal, light = torch.nn.functional.normalize(torch.randn(1, 3, 32, 32), dim=1), torch.rand(1, 16, 32, 3)
    hints = torch.rand(1, 3, 32, 32)
    with torch.inference_mode():
        exact = bundle.specular_shadow(normal, light, hints).shadow
        near = rounded.specular_shadow(normal, light, hints).shadow
        with torch.autocast("cpu", torch.bfloat16):
            autocast = bundle.specular_shadow(normal, light, hints).shadow
    assert near.dtype == torch.float32
    assert 0 < (near - exact).abs().max() < 0.05
    assert (near - autocast).abs().max() < 0.02


def test_a_rounded_bundle_leaves_the_original_whole():
    bundle = NetworkBundle(BundleConfig.tiny()).for_inference()
    rounded = bundle.rounded()
    assert {p.dtype for p in bundle.parameters()} == {torch.float32}
    assert rounded.composition.head.weight.dtype == torch.float32
    assert rounded.composition.encoder.stem.conv.weight.dtype == torch.bfloat16


@pytest.mark.parametrize("classes", [0, 5])
def test_what_was_begun_without_the_light_is_gone_on_with(classes):
    torch.manual_seed(0)
    network = SpecularShadowNetwork(SpecularShadowConfig(width=4, levels=3, parsing_classes=classes))
    for name, buffer in network.named_buffers():
        if name.endswith("running_var"):
            buffer.uniform_(0.5, 2)
        if name.endswith("running_mean"):
            buffer.normal_()
    network = fold_normalisation(network.eval().requires_grad_(False))
    normal, light = torch.nn.functional.normalize(torch.randn(1, 3, 32, 32), dim=1), torch.rand(1, 16, 32, 3)
    fixed, hints = torch.rand(1, classes + 1, 32, 32) if classes else None, torch.rand(1, 3, 32, 32)
    whole = network(normal, light, torch.cat([fixed, hints], 1) if classes else hints)
    begun = network.begin(normal, fixed)
    resumed = network(normal, light, hints, begun)
    torch.testing.assert_close(resumed.shadow, whole.shadow, rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(resumed.gloss, whole.gloss, rtol=1e-4, atol=1e-5)
    assert (network(normal, light, 1 - hints, begun).shadow - whole.shadow).abs().max() > 1e-3


def two_pairs(bundle):
    torch.manual_seed(2)
    narrow = RelightingPair(PairConfig(SpecularShadowConfig(width=3, levels=2), CompositionConfig(2, 2)))
    narrow.composition.head.weight.data.normal_(0, 0.1)
    return with_narrow_pair(bundle, narrow)


def test_two_pairs_come_back_with_their_widths(bundle, tmp_path):
    both = two_pairs(bundle)
    save_bundle(tmp_path / "w.safetensors", both, half=False)
    loaded = load_bundle(tmp_path / "w.safetensors")
    assert loaded.pair("narrow").specular_shadow.config.width == 3
    assert loaded.pair("wide").specular_shadow.config.width == 4
    assert "SS 4 channels in 3 levels" in loaded.card["widths"]
    assert "SS 3 channels in 2 levels" in loaded.card["widths"]
    for name, value in both.state_dict().items():
        torch.testing.assert_close(loaded.state_dict()[name], value, rtol=0, atol=0)


def test_where_there_is_one_pair_it_serves_for_both(bundle, tmp_path):
    save_bundle(tmp_path / "w.safetensors", bundle)
    loaded = load_bundle(tmp_path / "w.safetensors")
    assert loaded.narrow is None
    assert loaded.pair("narrow") is loaded.pair("wide")


def test_another_narrow_pair_takes_the_first_one_s_place(bundle):
    deeper = RelightingPair(PairConfig(SpecularShadowConfig(width=2, levels=4), CompositionConfig(2, 3)))
    both = two_pairs(with_narrow_pair(bundle, deeper))
    other = RelightingPair(PairConfig(SpecularShadowConfig(width=2, levels=2), CompositionConfig(2, 2)))
    again = with_narrow_pair(both, other)
    assert again.narrow.specular_shadow.config.width == 2
    assert torch.equal(again.specular_shadow.head.weight, bundle.specular_shadow.head.weight)


def test_a_narrow_pair_of_another_size_than_its_configuration_is_refused(bundle, tmp_path):
    both = two_pairs(bundle)
    save_bundle(tmp_path / "w.safetensors", both)
    with safe_open(tmp_path / "w.safetensors", framework="pt") as file:
        header = file.metadata()
    tensors = load_file(tmp_path / "w.safetensors")
    del header["sha256"]
    header["config"] = header["config"].replace('"width": 3', '"width": 5')
    save_file(tensors, tmp_path / "bad.safetensors", metadata=header)
    with pytest.raises(InputError, match="can't be read"):
        load_bundle(tmp_path / "bad.safetensors")


def test_a_file_written_before_there_were_pairs_is_read(bundle, tmp_path):
    save_bundle(tmp_path / "w.safetensors", bundle)
    with safe_open(tmp_path / "w.safetensors", framework="pt") as file:
        header = file.metadata()
    config = json.loads(header["config"])
    del config["narrow"]
    header["config"] = json.dumps(config)
    save_file(load_file(tmp_path / "w.safetensors"), tmp_path / "old.safetensors", metadata=header)
    assert load_bundle(tmp_path / "old.safetensors").config == bundle.config


def test_both_pairs_are_made_ready_and_rounded(bundle):
    ready = two_pairs(bundle).for_inference()
    light, normal = torch.rand(1, 16, 32, 3), torch.rand(1, 3, 16, 16)
    hints = torch.rand(1, 3, 16, 16)
    exact = ready.pair("narrow").specular_shadow(normal, light, hints).shadow
    rounded = ready.rounded().pair("narrow").specular_shadow(normal, light, hints).shadow
    assert not any(block.conv.weight.requires_grad for block in ready.narrow.modules() if hasattr(block, "conv"))
    assert not torch.equal(exact, rounded)
    torch.testing.assert_close(rounded, exact, rtol=0, atol=0.05)


@pytest.mark.parametrize(
    "grown",
    [
        lambda bundle: with_detail_pass(bundle, 4),
        two_pairs,
        lambda bundle: with_person_network(bundle, PersonNetwork(PersonConfig(4, 3, 8))),
    ],
)
def test_what_is_said_of_weights_goes_with_them_into_larger_bundles_and_is_changed_apart(bundle, grown):
    bundle.card = {"licence": "CC0"}
    larger = grown(bundle)
    assert larger.card["licence"] == "CC0"
    larger.card["steps"] = "9"
    assert bundle.card == {"licence": "CC0"}


def test_a_checksum_tells_names_types_and_shapes_apart():
    value = torch.zeros(2, 4)
    files = ({"a": value}, {"b": value}, {"a": value.T}, {"a": value.int()}, {"a": value + 1})
    assert len({checksum(tensors) for tensors in files}) == 5
    assert checksum({"a": value.T.contiguous().T, "b": value}) == checksum({"b": value, "a": value})
