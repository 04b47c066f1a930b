"""Training recipes: what is read from TOML, and that a run which was stopped goes on."""

import itertools
import json
from dataclasses import replace

import pytest
import torch
from small_runs import some_batch

from relight_core.errors import InputError
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle, with_residual_blocks
from relight_core.networks.delight import DelightConfig
from relight_core.training import run as run_module
from relight_core.training.recipe import follow, load_recipe, recipe_names


def written(tmp_path, text):
    path = tmp_path / "r.toml"
    path.write_text(text)
    return str(path)


SHORT = """
seed = 3
[networks.delight]
width = 4
levels = 3
[networks.specular_shadow]
width = 4
levels = 3
[networks.composition]
width = 4
levels = 2
[[stage]]
name = "warm-delight"
steps = 2
[[stage]]
name = "warm-delight"
steps = 2
detail_width = 4
[[stage]]
name = "warm-relight"
steps = 2
"""


@pytest.fixture
def data(monkeypatch):
    """Batches without heads or lights."""
    asked = []

    def batches(run, stage, first_batch):
        asked.append((run.stage, run.seed, first_batch))
        torch.manual_seed(run.seed)
        return itertools.repeat(some_batch())

    monkeypatch.setattr(run_module, "training_batches", batches)
    return asked


def test_pairs_of_a_stage_are_used_as_often_as_the_recipe_says(tmp_path, monkeypatch):
    asked = []

    def batches(run, stage, first_batch):
        asked.append((run.uses, run.window))
        return itertools.repeat(some_batch())

    monkeypatch.setattr(run_module, "training_batches", batches)
    text = SHORT.replace('"warm-relight"\nsteps = 2', '"warm-relight"\nsteps = 2\nuses = 3\nwindow = 99')
    follow(load_recipe(written(tmp_path, text)), tmp_path, tmp_path, tmp_path / "out", lambda *_: None)
    assert asked == [(1, 1024), (1, 1024), (3, 99)]


def test_bundled_recipes_can_be_read():
    assert {"paper", "shipped"} <= set(recipe_names())
    for name in recipe_names():
        assert load_recipe(name).stages


def test_the_paper_s_recipe_has_none_of_our_variants():
    recipe = load_recipe("paper")
    assert not recipe.networks.delight.anchored
    assert not recipe.networks.specular_shadow.per_pixel_light
    assert not recipe.networks.specular_shadow.relief_shadow
    assert not recipe.networks.composition.explicit_sum
    assert [stage.learning_rate for stage in recipe.stages] == [2e-3, 2e-3, 2e-3, 2e-4, 2e-4]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "stage"),
        ("[[stage]]\nname = 'warm-delight'", "minutes"),
        ("[[stage]]\nname = 'warm-delight'\nminutes = 1\nsteps = 1", "minutes"),
        ("[[stage]]\nname = 'cook'\nsteps = 1", "cook"),
        ("[[stage]]\nname = 'warm-delight'\nsteps = -1", "steps"),
        ("[[stage]]\nname = 'warm-delight'\nsteps = 1\nspeed = 2", "speed"),
        ("colour = 1\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "colour"),
        ("[[stage]]\nsteps = 1", "a stage has no name"),
        ("[[stage]]\nname = ['warm-delight']\nsteps = 1", "a stage has no name"),
        ("[networks.delight]\nheight = 4\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "unknown entry 'height'"),
        ("[networks.hair]\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "hair"),
        ("[networks.narrow]\nwidth = 8\n[[stage]]\nname = 'outline'\nsteps = 1", "unknown network 'narrow': one of"),
        ("[networks.to_json]\n[[stage]]\nname = 'outline'\nsteps = 1", "unknown network 'to_json': one of delight"),
        ("[networks.delight]\nclasses = 3\n[[stage]]\nname = 'outline'\nsteps = 1", "classes can't be 3; write 14"),
        ("[networks.person]\nwidest = 0\n[[stage]]\nname = 'outline'\nsteps = 1", "widest can't be 0"),
        ("seed = -1\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "seed"),
        ("seed = 0.5\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "seed"),
        ("[[stage]]\nname = 'warm-delight'\nsteps = 1.5", "whole"),
        ("[[stage]]\nname = 'warm-delight'\nsteps = 1\npairs = 1.5", "whole"),
        ("[[stage]]\nname = 'outline'\nsteps = 1\nuses = 2", "once"),
        ("[[stage]]\nname = 'foreign-shadow'\nsteps = 1\nuses = 2", "once"),
        ("[networks.delight]\nwidth = '4'\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "width"),
        (
            "[networks.delight]\nresidual = [0, 1, -1, 0, 0, 0]\n[[stage]]\nname = 'outline'\nsteps = 1",
            "residual",
        ),
        (
            "[networks.delight]\nresidual = [0, 1, '1', 0, 0, 0]\n[[stage]]\nname = 'outline'\nsteps = 1",
            "residual",
        ),
        ("[networks.delight]\nresidual = 2\n[[stage]]\nname = 'outline'\nsteps = 1", "residual"),
        ("[stage]\nname = 'warm-delight'\nsteps = 1", r"\[\[stage\]\]"),
        ("stage = ['warm-delight']", r"\[\[stage\]\]"),
        ("networks = 3\n[[stage]]\nname = 'warm-delight'\nsteps = 1", r"\[networks\]"),
        ("[networks]\ndelight = 28\n[[stage]]\nname = 'warm-delight'\nsteps = 1", r"\[networks.delight\]"),
        ("[networks.delight]\nlevels = 0\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "levels"),
        ("[networks.delight]\nclasses = -1\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "classes"),
        ("[[stage]]\nname = 'warm-delight'\nminutes = inf", "minutes"),
        ("[[stage]]\nname = 'warm-delight'\nminutes = true", "minutes"),
        ("seed = 9223372036854775807\n[[stage]]\nname = 'warm-delight'\nsteps = 1", "seed"),
        ("not toml", "r.toml"),
    ],
)
def test_what_no_run_understands_is_refused(text, word, tmp_path):
    with pytest.raises(InputError, match=word):
        load_recipe(written(tmp_path, text))


def test_an_unknown_name_lists_the_known(tmp_path):
    with pytest.raises(InputError, match="paper"):
        load_recipe(str(tmp_path / "none.toml"))


def test_minutes_and_steps_add_up_to_how_long_a_recipe_takes(tmp_path):
    minutes = "[[stage]]\nname = 'warm-delight'\nminutes = 10"
    steps = "[[stage]]\nname = 'tune-delight'\nsteps = 3600\npairs = 2\nsize = 128"
    recipe = load_recipe(str(written(tmp_path, f"{minutes}\n{steps}")))
    assert recipe.expected_minutes(0, 0.5) == 5
    assert recipe.expected_minutes(1, 0) == 10
    assert recipe.expected_minutes(1, 1) == pytest.approx(22.75)


def test_stages_follow_each_other(tmp_path, data):
    recipe = load_recipe(written(tmp_path, SHORT))
    out = tmp_path / "out"
    result = follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    assert [stage for stage, _, _ in data] == ["warm-delight", "warm-delight", "warm-relight"]
    assert len({seed for _, seed, _ in data}) == 3
    assert result.config.delight.detail_width == 4
    assert load_bundle(out / "relight.safetensors").config == result.config
    data.clear()
    follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    assert data == []
    (out / "03-warm-relight.safetensors").unlink()
    follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    assert [stage for stage, _, _ in data] == ["warm-relight"]


def test_networks_that_the_start_has_not_are_no_longer_asked_for_in_vain(tmp_path, data):
    save_bundle(tmp_path / "start.safetensors", NetworkBundle(BundleConfig.tiny()))
    recipe = load_recipe(written(tmp_path, SHORT))
    fitting = replace(recipe, networks=BundleConfig.tiny())
    follow(fitting, tmp_path, tmp_path, tmp_path / "out", lambda *progress: None, tmp_path / "start.safetensors")
    wider = replace(fitting, networks=replace(BundleConfig.tiny(), delight=DelightConfig(width=6, levels=3)))
    with pytest.raises(InputError, match="networks.delight"):
        follow(wider, tmp_path, tmp_path, tmp_path / "other", lambda *progress: None, tmp_path / "start.safetensors")
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize("name", ["person", "foreign_shadow"])
def test_a_recipe_may_size_the_networks_beside_the_first_three(name, tmp_path):
    recipe = load_recipe(written(tmp_path, f"[networks.{name}]\nwidth = 8\n" + SHORT[SHORT.index("[[stage]]") :]))
    assert getattr(recipe.networks, name).width == 8


def test_a_detail_pass_changes_nothing_until_it_is_trained(tmp_path):
    from relight_core.networks.bundle import with_detail_pass

    torch.manual_seed(0)
    coarse = NetworkBundle(BundleConfig.tiny()).eval()
    fine = with_detail_pass(coarse, 8).eval()
    photo = torch.rand(1, 3, 32, 32)
    with torch.no_grad():
        small = coarse.delight(torch.nn.functional.avg_pool2d(photo, 2))
        large = fine.delight(photo)
    assert large.albedo_srgb.shape == photo.shape
    torch.testing.assert_close(large.light, small.light)
    in_pixels = 2 * torch.nn.functional.interpolate(small.relief, scale_factor=2, mode="bilinear")
    torch.testing.assert_close(large.relief, in_pixels)
    save_bundle(tmp_path / "f.safetensors", fine, half=False)
    again = load_bundle(tmp_path / "f.safetensors").eval()
    with torch.no_grad():
        torch.testing.assert_close(again.delight(photo).normal, large.normal)


class TestResidualBlocks:
    def bundle(self):
        torch.manual_seed(0)
        return NetworkBundle(BundleConfig.tiny())

    @pytest.mark.parametrize("settled", [False, True])
    def test_change_nothing_until_they_are_trained(self, tmp_path, settled):
        plain = self.bundle().eval()
        deeper = with_residual_blocks(self.bundle(), (0, 1, 2), (1, 2), settled=settled).eval()
        assert len(deeper.delight.decoder[0].residual) == 2
        save_bundle(tmp_path / "d.safetensors", deeper, half=False)
        again = load_bundle(tmp_path / "d.safetensors").for_inference()
        photo = torch.rand(1, 3, 32, 32)
        with torch.no_grad():
            expected, found, folded = (bundle.delight(photo) for bundle in (plain, deeper, again))
        torch.testing.assert_close(found.normal, expected.normal)
        torch.testing.assert_close(folded.normal, expected.normal, atol=1e-4, rtol=1e-4)

    def test_learn(self):
        deeper = with_residual_blocks(self.bundle(), (0, 0, 1)).train()
        block = deeper.delight.encoder.levels[-1][-1]
        deeper.delight(torch.rand(2, 3, 32, 32)).light.sum().backward()
        assert block.second.norm.weight.grad.abs().sum() > 0

    def test_learn_by_their_convolutions_where_statistics_hold(self):
        deeper = with_residual_blocks(self.bundle(), (0, 0, 1), settled=True).eval()
        block = deeper.delight.encoder.levels[-1][-1]
        deeper.delight(torch.rand(2, 3, 32, 32)).light.sum().backward()
        assert block.second.conv.weight.grad.abs().sum() > 0

    def test_of_the_decoder_learn_and_leave_the_encoder_as_it_is(self):
        before = with_residual_blocks(self.bundle(), (0, 0, 1))
        deeper = with_residual_blocks(before, decoder=(1, 0), settled=True).eval()
        assert deeper.config.delight.residual == (0, 0, 1)
        deeper.delight(torch.rand(2, 3, 32, 32)).normal[:, 0].sum().backward()
        assert deeper.delight.decoder[-1].residual[0].second.conv.weight.grad.abs().sum() > 0

    def test_taught_ones_are_kept_when_more_are_added(self):
        taught = with_residual_blocks(self.bundle(), (0, 0, 1))
        block = taught.delight.encoder.levels[-1][-1]
        torch.nn.init.constant_(block.second.norm.weight, 0.5)
        deeper = with_residual_blocks(taught, (0, 0, 2), settled=True).delight.encoder.levels[-1]
        torch.testing.assert_close(deeper[-2].first.conv.weight, block.first.conv.weight)
        torch.testing.assert_close(deeper[-2].second.norm.weight, torch.full_like(block.second.norm.weight, 0.5))
        assert not deeper[-1].second.conv.weight.any()

    def test_none_that_are_there_are_taken_away(self):
        taught = with_residual_blocks(self.bundle(), (0, 1, 1), (1, 0))
        for fewer in ({"encoder": (0, 0, 1)}, {"encoder": (0, 1, 1), "decoder": (0, 1)}):
            with pytest.raises(InputError, match="residual blocks already"):
                with_residual_blocks(taught, **fewer)
        assert with_residual_blocks(taught, (0, 1, 2)).config.delight.residual == (0, 1, 2)

    def test_for_other_levels_are_refused(self):
        with pytest.raises(InputError, match="3 numbers"):
            with_residual_blocks(self.bundle(), (0, 1))
        with pytest.raises(InputError, match="2 numbers"):
            with_residual_blocks(self.bundle(), decoder=(0, 1, 1))


def test_a_folder_s_stages_are_not_taken_for_another_run_s(tmp_path, data):
    recipe, out = replace(load_recipe(written(tmp_path, SHORT)), networks=BundleConfig.tiny()), tmp_path / "out"
    wider = replace(BundleConfig.tiny(), delight=DelightConfig(width=6, levels=3))
    save_bundle(tmp_path / "start.safetensors", NetworkBundle(BundleConfig.tiny()))

    def followed(recipe, start=None):
        follow(recipe, tmp_path, tmp_path, out, lambda *progress: None, start)

    followed(recipe)
    data.clear()
    with pytest.raises(InputError, match="another kind of networks"):
        followed(replace(recipe, networks=wider))
    with pytest.raises(InputError, match="another seed"):
        followed(replace(recipe, seed=4))
    with pytest.raises(InputError, match="another --start"):
        followed(recipe, tmp_path / "start.safetensors")
    with pytest.raises(InputError, match="another plan for 01-warm-delight"):
        followed(replace(recipe, stages=(replace(recipe.stages[0], learning_rate=1e-5), *recipe.stages[1:])))
    followed(recipe)
    assert data == []


def test_a_finished_run_is_not_taken_for_one_on_other_heads(tmp_path, data):
    recipe, out = replace(load_recipe(written(tmp_path, SHORT)), networks=BundleConfig.tiny()), tmp_path / "out"
    (tmp_path / "head-0000000.npz").write_bytes(b"one")
    follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    (tmp_path / "head-0000001.npz").write_bytes(b"another")
    with pytest.raises(InputError, match="another set of heads and lights"):
        follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    note = json.loads((out / "begun.json").read_text())
    del note["heads and lights"]
    (out / "begun.json").write_text(json.dumps(note))
    data.clear()
    follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    assert data == []


def test_a_run_that_was_refused_keeps_no_other_from_its_folder(tmp_path, data):
    recipe = load_recipe(written(tmp_path, "[[stage]]\nname = 'distil-relight'\nsteps = 1\nexamples = 1"))
    recipe, out = replace(recipe, networks=BundleConfig.tiny()), tmp_path / "out"
    start = tmp_path / "start.safetensors"
    save_bundle(start, NetworkBundle(BundleConfig.tiny()))
    with pytest.raises(InputError, match="weights to start from, after --start"):
        follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    mended = replace(recipe, stages=(replace(recipe.stages[0], name="warm-relight"),))
    follow(mended, tmp_path, tmp_path, out, lambda *progress: None, start)
    with pytest.raises(InputError, match="another --start"):
        follow(mended, tmp_path, tmp_path, out, lambda *progress: None)


def tiny_recipe(tmp_path, *stages, effects=True):
    text = "".join(f"[[stage]]\nname = '{stage}'\nsteps = 1\n" for stage in stages)
    tiny = BundleConfig.tiny()
    networks = replace(tiny, composition=replace(tiny.composition, effects=effects))
    return replace(load_recipe(written(tmp_path, text)), networks=networks)


@pytest.mark.parametrize(
    "stages",
    [
        ("warm-delight", "tune-delight"),
        ("warm-delight", "warm-composition", "tune-delight"),
        ("warm-relight", "tune-relight", "warm-delight"),
    ],
)
def test_a_recipe_that_learns_through_networks_it_has_not_trained_is_refused_before_its_first_stage(
    tmp_path, data, stages
):
    with pytest.raises(InputError, match="tune-.* learns from trained networks"):
        follow(tiny_recipe(tmp_path, *stages), tmp_path, tmp_path, tmp_path / "out", lambda *_: None)
    assert data == []


@pytest.mark.parametrize(
    ("stages", "effects"),
    [
        (("warm-delight", "warm-relight", "tune-delight"), True),
        (("warm-delight", "warm-composition", "tune-delight"), False),
    ],
)
def test_a_recipe_that_trains_all_that_it_learns_through_needs_no_weights_to_start_from(
    tmp_path, data, stages, effects
):
    follow(tiny_recipe(tmp_path, *stages, effects=effects), tmp_path, tmp_path, tmp_path / "out", lambda *_: None)
    assert [stage for stage, _, _ in data] == list(stages)


def test_a_stage_is_not_taken_for_the_same_one_after_another(tmp_path, data):
    recipe, out = replace(load_recipe(written(tmp_path, SHORT)), networks=BundleConfig.tiny()), tmp_path / "out"
    first, second, last = recipe.stages
    follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    data.clear()
    other = replace(recipe, stages=(first, replace(second, name="warm-composition"), last))
    with pytest.raises(InputError, match="another plan for 03-warm-relight"):
        follow(other, tmp_path, tmp_path, out, lambda *progress: None)
    longer = replace(recipe, stages=(*recipe.stages, replace(last, name="warm-composition")))
    follow(longer, tmp_path, tmp_path, out, lambda *progress: None)
    assert [stage for stage, _, _ in data] == ["warm-composition"]


def test_a_finished_run_s_result_is_not_replaced_by_a_shorter_recipe_s(tmp_path, data):
    recipe, out = replace(load_recipe(written(tmp_path, SHORT)), networks=BundleConfig.tiny()), tmp_path / "out"
    follow(recipe, tmp_path, tmp_path, out, lambda *progress: None)
    before = (out / "relight.safetensors").read_bytes()
    shorter = replace(recipe, stages=recipe.stages[:2])
    with pytest.raises(InputError, match="holds 03-warm-relight, which the recipe has not"):
        follow(shorter, tmp_path, tmp_path, out, lambda *progress: None)
    assert (out / "relight.safetensors").read_bytes() == before


def test_a_stage_of_a_few_steps_keeps_what_they_taught(tmp_path, data):
    recipe = replace(load_recipe(written(tmp_path, SHORT)), networks=BundleConfig.tiny())
    start = NetworkBundle(BundleConfig.tiny())
    save_bundle(tmp_path / "start.safetensors", start, half=False)
    warm = replace(recipe, stages=recipe.stages[:1])
    follow(warm, tmp_path, tmp_path, tmp_path / "out", lambda *progress: None, tmp_path / "start.safetensors")
    result = load_bundle(tmp_path / "out" / "01-warm-delight.safetensors")
    moved = [
        not torch.equal(new, old)
        for new, old in zip(result.delight.parameters(), start.delight.parameters(), strict=True)
    ]
    assert any(moved)
