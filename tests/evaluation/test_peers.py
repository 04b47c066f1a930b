"""Others' methods: what their papers promise on portraits small enough to reason about."""

import itertools

import numpy as np
import pytest
import torch
from torch import nn

from relight_core.errors import InputError
from relight_core.evaluation.contest import Task
from relight_core.evaluation.peers import sun
from relight_core.evaluation.peers.blurring import blurred_within
from relight_core.evaluation.peers.dpr import Dpr, DprNetwork, harmonics, load_dpr
from relight_core.evaluation.peers.shih import Shih, transfer_statistics
from relight_core.evaluation.peers.shu import Shu, transfer_by_transport
from relight_core.evaluation.peers.sun import Sun, SunConfig, SunModel, load_sun, sun_losses
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.sphere import directions
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.training.run import Run

SIZE = 32


@pytest.fixture
def covered():
    axis = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    return x**2 + y**2 < 0.8


@pytest.fixture
def surface(covered):
    axis = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    normal = np.stack([x, y, z], -1).astype(np.float32) * covered[..., None]
    return {"normal": normal, "relief": (z * covered).astype(np.float32)}


def lit_from(surface, direction, texture=0.0):
    """A grey ball with a fine checked texture, lit by a lamp."""
    checks = np.indices((SIZE, SIZE)).sum(0) % 2
    shading = np.clip(surface["normal"] @ np.array(direction), 0, None) * 0.7 + 0.1
    grey = shading * (1 + texture * (checks - 0.5)) * surface["normal"].any(-1)
    return np.repeat(grey[..., None], 3, 2).astype(np.float32)


def rms(image, covered):
    return float(np.sqrt((image[covered] ** 2).mean()))


def test_what_lies_beside_the_head_has_no_say_in_its_blur(covered):
    image = np.where(covered[..., None], np.float32([0.2, 0.5, 0.8]), np.float32(9))
    blurred = blurred_within(image, covered.astype(np.float32), 2.5)
    np.testing.assert_allclose(blurred[covered], image[covered], rtol=1e-5)


@pytest.mark.parametrize("given", ["itself", "another"])
def test_local_statistics_of_the_example_come_over(given, surface, covered):
    photo, example = lit_from(surface, (0.8, 0, 0.6)), lit_from(surface, (-0.8, 0, 0.6))
    example = photo if given == "itself" else example
    made = transfer_statistics(photo, example, covered)
    assert rms(made - example, covered) < 0.5 * max(rms(photo - example, covered), 0.06)
    assert not made[~covered].any()
    assert 0 <= made.min() <= made.max() <= 1


def checkered(image, covered):
    """How much neighbours differ, within the head."""
    moved = [np.roll(covered, step, axis) for step in (3, -3) for axis in (0, 1)]
    inner, grey = np.logical_and.reduce([covered, *moved]), image[..., 0]
    return float(np.abs(grey[1:, :] - grey[:-1, :])[inner[1:, :]].mean())


def test_the_photo_s_own_texture_survives_the_example_s_light(surface, covered):
    photo, example = lit_from(surface, (0.8, 0, 0.6), texture=0.3), lit_from(surface, (-0.8, 0, 0.6))
    made = transfer_statistics(photo, example, covered)
    assert checkered(made, covered) > 2 * checkered(example, covered)
    assert checkered(made, covered) > 0.75 * checkered(photo, covered)


@pytest.mark.parametrize(("texture", "least", "most"), [(0.2, 1.3, 1.7), (0.03, 2.0, 2.9)])
def test_a_texture_becomes_as_strong_as_the_example_s_but_by_no_more_than_its_limit(
    surface, covered, texture, least, most
):
    photo, example = (lit_from(surface, (0.0, 0, 1.0), texture=strength) for strength in (texture, 0.3))
    made = transfer_statistics(photo, example, covered)
    assert least < checkered(made, covered) / checkered(photo, covered) < most


def test_transport_gives_each_place_the_example_s_colours(surface, covered):
    photo, example = lit_from(surface, (0.8, 0, 0.6)), lit_from(surface, (-0.8, 0, 0.6)) * [1, 0.8, 0.6]
    example = example.astype(np.float32)
    made = transfer_by_transport(photo, example, surface["normal"], surface["relief"], covered)
    assert rms(made - example, covered) < 0.6 * rms(photo - example, covered)
    np.testing.assert_allclose(made[covered].mean(0), example[covered].mean(0), atol=0.05)
    assert not made[~covered].any()


def test_transport_onto_itself_changes_nothing(surface, covered):
    photo = lit_from(surface, (0.8, 0, 0.6))
    made = transfer_by_transport(photo, photo, surface["normal"], surface["relief"], covered)
    np.testing.assert_allclose(made[covered], photo[covered], atol=2e-3)


@pytest.mark.parametrize("peer", [Shih(), Shu()])
def test_who_is_given_the_truth_is_measured_at_its_exposure(peer, surface, covered):
    truth = lit_from(surface, (0.0, 0, 1.0)) ** 2.2
    task = Task(np.ones((16, 32, 3), np.float32), 2.0, np.clip(truth * 2, 0, 1), covered, surface)
    made = peer.relight(peer.look(task.reference), task)["composition"]
    assert rms(made - truth, covered) < 0.15 * rms(truth, covered)
    assert peer.channels(peer.look(task.reference)) == {}


def some_pairs(pairs=2, size=16):
    torch.manual_seed(1)
    covered = torch.ones(pairs, 1, size, size)
    image = torch.rand(pairs, 2, 3, size, size)
    return {
        "photo_srgb": image.clamp(0, 1),
        "image": image,
        "covered": covered,
        "light": torch.rand(pairs, 2, 16, 32, 3) * 2,
    }


class TestSun:
    def model(self):
        torch.manual_seed(0)
        return SunModel(SunConfig(width=4, levels=3))

    def test_every_weight_learns_from_the_three_losses(self):
        model = self.model()
        nn.init.constant_(model.network.head.bias, 0.5)
        losses = sun_losses(model, ReflectionTable(), some_pairs())
        assert {"relit", "same", "light"} <= set(losses)
        sum(losses.values()).backward()
        assert all(weight.grad is not None for weight in model.parameters())
        assert model.network.bottleneck.fc1.weight.grad.abs().sum() > 0
        assert model.network.light.propose.weight.grad.abs().sum() > 0

    def test_each_photo_is_relit_with_the_other_light_of_its_pair(self):
        model, batch, told = self.model(), some_pairs(), []
        decode = model.network.decode
        model.network.decode = lambda features, light: (told.append(light), decode(features, light))[1]
        sun_losses(model, ReflectionTable(), batch)
        torch.testing.assert_close(told[0][0], batch["light"][0, 1])
        torch.testing.assert_close(told[0][1], batch["light"][0, 0])

    def test_a_picture_that_is_true_on_the_head_costs_nothing_whatever_lies_beside_it(self):
        model, batch = self.model(), some_pairs()
        batch["covered"][0, ..., 8:] = batch["covered"][1, ..., :8] = 0
        lights, beside = batch["light"].flatten(0, 1), 1 - batch["covered"].repeat_interleave(2, 0)

        def decode(features, light):
            numbers = [next(n for n, known in enumerate(lights) if torch.equal(known, one)) for one in light]
            return batch["image"].flatten(0, 1)[numbers] + 5 * beside

        model.network.encode = lambda photos: ([photos], lights)
        model.network.decode = decode
        losses = sun_losses(model, ReflectionTable(), batch)
        for name in ("relit", "same", "light", "irradiance"):
            assert float(losses[name]) == pytest.approx(0, abs=1e-6), name

    def test_a_training_that_goes_on_goes_round_in_its_batches_from_where_it_was(self, tmp_path, monkeypatch):
        told = []
        monkeypatch.setattr(sun, "train_stage", lambda *given: told.append(given))
        monkeypatch.setattr(sun, "shared_batches", lambda run, first: itertools.count(first))
        sun.train_sun(Run("", tmp_path, tmp_path, tmp_path / "sun" / "s.safetensors", size=64), 9, 3)
        ((_, model, batches_from, *_, drawn_by),) = told
        assert [list(itertools.islice(batches_from(first), 5)) for first in (0, 4)] == [
            [0, 1, 2, 0, 1],
            [1, 2, 0, 1, 2],
        ]
        assert (drawn_by["batches"], drawn_by["size"]) == (3, 64)
        assert Sun(model).size_px == 64

    def test_weights_come_back_and_others_are_refused(self, tmp_path, surface, covered):
        model = self.model().eval()
        save_bundle(tmp_path / "s.safetensors", model, half=False)
        again = load_sun(tmp_path / "s.safetensors")
        assert again.config == model.config
        photo = lit_from(surface, (0.6, 0, 0.8))
        task = Task(np.ones((16, 32, 3), np.float32), 1.0, photo, covered, surface)
        one, other = (Sun(m).relight(Sun(m).look(photo), task)["composition"] for m in (model, again))
        np.testing.assert_array_equal(one, other)
        encoded = np.where(photo <= 0.0031308, 12.92 * photo, 1.055 * photo ** (1 / 2.4) - 0.055)
        with torch.no_grad():
            _, light = model.network.encode(torch.from_numpy(encoded).permute(2, 0, 1)[None].float())
        np.testing.assert_allclose(Sun(again).channels(Sun(again).look(photo))["guess"], light[0], rtol=1e-3)
        with pytest.raises(InputError, match=r"not the weights of relight's networks \(their header has no 'specular_"):
            load_bundle(tmp_path / "s.safetensors")
        save_bundle(tmp_path / "ours.safetensors", NetworkBundle(BundleConfig.tiny()))
        with pytest.raises(InputError, match="their header has no 'sun'"):
            load_sun(tmp_path / "ours.safetensors")
        (tmp_path / "t.safetensors").write_bytes(b"nothing")
        with pytest.raises(InputError, match=r"t\.safetensors"):
            load_sun(tmp_path / "t.safetensors")

    def test_pictures_larger_than_it_was_trained_on_are_relit_at_its_own_size(self, tmp_path, surface, covered):
        model = self.model().eval()
        model.card = {"size_px": "32"}
        save_bundle(tmp_path / "s.safetensors", model, half=False)
        own, other = Sun(load_sun(tmp_path / "s.safetensors")), Sun(model)
        rng = np.random.default_rng(5)
        small, light = rng.random((32, 32, 3), np.float32), rng.random((16, 32, 3), np.float32)
        large = small.repeat(2, 0).repeat(2, 1)
        made = own.relight(own.look(large), Task(light, 1.0, large, covered, surface))["composition"]
        at_32 = other.relight(other.look(small), Task(light, 1.0, small, covered, surface))["composition"]
        assert made.shape == (64, 64, 3)
        shrunk = made.reshape(32, 2, 32, 2, 3).mean((1, 3))
        assert np.corrcoef(shrunk.ravel(), at_32.ravel())[0, 1] > 0.95
        assert own.in_words().endswith(", trained at 32 pixels, and relights larger pictures at that.")
        assert other.in_words() == own.in_words()

    def test_a_size_that_no_file_tells_is_not_told_as_a_number(self):
        words = Sun(self.model()).in_words()
        assert "does not tell" in words
        assert not any(letter.isdigit() for letter in words)


def their_names(network):
    """A state of ours under the names that their file has."""
    names = {"stem.": "pre_conv.", "stem_norm.": "pre_bn.", "hourglass.": "HG3."}
    names |= {f"convolutions.{n}.": f"conv_{n + 1}." for n in range(3)} | {
        f"norms.{n}.": f"bn_{n + 1}." for n in range(3)
    }
    state = {}
    for name, value in network.state_dict().items():
        old = next((prefix for prefix in names if name.startswith(prefix)), "")
        state[names.get(old, "") + name.removeprefix(old)] = value
    inner = {name.removeprefix("HG3.middle."): value for name, value in state.items() if name.startswith("HG3.middle.")}
    return state | {f"HG2.{name}": value for name, value in inner.items()}


class TestDpr:
    def test_a_checkpoint_with_their_names_is_read(self, tmp_path):
        torch.manual_seed(0)
        network = DprNetwork().eval()
        torch.save(their_names(network), tmp_path / "d.t7")
        again = load_dpr(tmp_path / "d.t7")
        lightness, light = torch.rand(1, 1, 32, 32), torch.rand(1, 9, 1, 1)
        with torch.no_grad():
            for one, other in zip(network(lightness, light), again(lightness, light), strict=True):
                torch.testing.assert_close(one, other)
        assert again(lightness, light)[1].shape == (1, 9, 1, 1)

    def test_a_missing_file_says_where_it_is_to_be_had(self, tmp_path):
        with pytest.raises(InputError, match="not shipped"):
            load_dpr(tmp_path / "none.t7")

    @pytest.mark.parametrize("content", [b"", b"nonsense", None])
    def test_another_file_is_refused_in_a_line(self, content, tmp_path):
        path = tmp_path / "d.t7"
        if content is None:
            torch.save({"pre_conv.weight": torch.zeros(1)}, path)
        else:
            path.write_bytes(content)
        with pytest.raises(InputError, match=r"d\.t7") as caught:
            load_dpr(path)
        assert "\n" not in str(caught.value)

    @pytest.mark.parametrize(("direction", "place", "sign"), [((1, 0, 0), 3, 1), ((0, 1, 0), 2, 1), ((0, 0, 1), 1, -1)])
    def test_a_lamp_shows_in_the_harmonic_of_its_axis(self, direction, place, sign):
        lamp = (directions(16, 32) @ np.array(direction) > 0.9).astype(np.float32)[..., None].repeat(3, 2)
        found = harmonics(lamp)
        assert found.shape == (9,)
        assert np.argmax(np.abs(found[1:4])) + 1 == place
        assert np.sign(found[place]) == sign
        assert found[0] == pytest.approx(0.76, rel=1e-3)

    def test_a_point_of_light_has_the_harmonics_of_its_direction_in_their_axes(self):
        point = directions(64, 128) @ np.array([0.48, 0.6, 0.64]) > 0.995
        x, y, z = 0.48, -0.64, 0.6
        basis = [
            *(0.2820948, 0.4886025 * y, 0.4886025 * z, 0.4886025 * x, 1.0925484 * y * x, 1.0925484 * y * z),
            *(0.3153916 * (3 * z**2 - 1), 1.0925484 * x * z, 0.5462742 * (x**2 - y**2)),
        ]
        expected = 0.76 / 0.2820948 * np.array(basis)
        found = harmonics(point.astype(np.float32)[..., None].repeat(3, 2))
        np.testing.assert_allclose(found, expected, atol=0.03)

    def test_an_even_light_has_the_first_harmonic_alone(self):
        found = harmonics(np.ones((16, 32, 3), np.float32))
        assert np.abs(found[1:]).max() < 0.01

    def test_colours_stay_the_photo_s(self, surface, covered):
        torch.manual_seed(0)
        photo = lit_from(surface, (0.0, 0, 1.0)) * np.array([0.8, 0.5, 0.4], np.float32)
        peer = Dpr(DprNetwork().eval(), size=32)
        task = Task(np.ones((16, 32, 3), np.float32), 1.0, photo, covered, surface)
        made = peer.relight(peer.look(photo), task)["composition"]
        assert made.shape == photo.shape
        assert np.isfinite(made).all()
        assert (made[covered][:, 0] >= made[covered][:, 2]).mean() > 0.95

    def test_a_network_that_changes_nothing_gives_the_photo_at_its_exposure(self, surface, covered):
        photo = lit_from(surface, (0.0, 0, 1.0)) * np.array([0.8, 0.5, 0.4], np.float32)
        told = []
        peer = Dpr(lambda lightness, light: (told.append((lightness, light)) or lightness, None), size=SIZE)
        seen = peer.look(photo)
        kept = seen.copy()
        light = np.random.default_rng(0).random((16, 32, 3), np.float32)
        made = peer.relight(seen, Task(light, 2.0, photo, covered, surface))["composition"]
        # OpenCV's Lab is as exact as its tables.
        np.testing.assert_allclose(2 * made, photo, atol=5e-3)
        np.testing.assert_array_equal(seen, kept)
        ((lightness, harmonic),) = told
        assert lightness.shape == (1, 1, SIZE, SIZE)
        assert 0.5 < lightness.max() <= 1
        np.testing.assert_allclose(harmonic.flatten(), harmonics(light))
