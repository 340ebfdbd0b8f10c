"""What a real sensor makes of clean returns, one function an effect; `observe` applies all.

The effects of a `SensorModel`, in the order of the light: power by range and response, loss in the air, the echo of
each beam, panes that are looked through, the scatter of powers, what hangs in the air, the threshold, intensity, range
noise.
"""

from __future__ import annotations

import math

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.scene.layout import Layout
from lidardraft.scene.noise import draws, exponential_quantiles, normal, smooth_noise
from lidardraft.scene.range_image import IMAGES, RangeImage
from lidardraft.scene.receiver import Echoes, mixed_pixels, rays_of, receive, winners
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel, beam_fan, sub_rays
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather, first_drop, fog_echo

# Behind a pane: the share of beams that meet something within reach, its mean depth [m] and response (seats, curtains,
# rooms): estimates of ours.
_BEHIND_SHARE, _BEHIND_DEPTH, _BEHIND_RESPONSE = 0.5, 1.0, 0.25
_CARRIED = ("label", "instance", "primitive", "incidence")  # images of the ray that an echo is of
# Pixels are looked at in blocks of so many sub-rays: what is larger than the cache, and than what the allocator keeps,
# takes three times as long.
_BLOCK = 49_152
_GRAZING = 0.3  # cosine of incidence below which rays meet the tops of a rough surface: an estimate of ours
_STAINED = 1.2  # standard deviations of the dust's pattern above which there is a stain


def observe(
    image: RangeImage,
    layout: Layout | Surfaces,
    rng: np.random.Generator | int,
    *,
    sensor: Sensor | None = None,
    model: SensorModel | None = None,
    weather: Weather | None = None,
) -> RangeImage:
    """What `sensor` reports of the clean image cast of `layout`, with intensity, primitive and incidence.

    The image is cast by `sub_rays(sensor, model)`, with primitive and incidence; or by the sensor itself, which needs
    no `sensor` here: then a beam is one ray. `model` is by default the preset of the sensor's name. `Surfaces.of`
    the layout, made once, saves time where one layout is scanned often (and holds the wetness of its ground).

    Raises `SensorError` for an image of another sensor or without primitive and incidence, `LayoutError` for a material
    that is unknown.
    """
    rng = np.random.Generator(np.random.SFC64(rng)) if isinstance(rng, int) else rng
    weather = weather or Weather()
    model = model or SensorModel.of(sensor or image.sensor)
    if sensor is None:
        sensor, fan = image.sensor, np.array([[0.0, 0.0, 1.0]])
    else:
        fan = beam_fan(model)
        rays = sub_rays(sensor, model)
        if image.sensor is not rays and image.sensor != rays:
            raise SensorError(f"the image is of {image.sensor.name}; sub_rays of {sensor.name} are {rays.name}")
    surfaces = layout if isinstance(layout, Surfaces) else Surfaces.of(layout, wetness=weather.wetness)
    surfaces.check(image)
    beams, columns = sensor.shape
    subs = {name: getattr(image, name).reshape(beams, len(fan), columns) for name in ("depth", *_CARRIED)}
    seen = {name: np.empty(sensor.shape, IMAGES[name]) for name in ("depth", "intensity", *_CARRIED)}
    patches = smooth_noise(sensor.shape, rng)
    logarithm, offsets = gains(model, patches), range_offsets(model, beams)
    shares = fan[:, 2].astype(np.float32)
    step = max(1, _BLOCK // (len(fan) * columns))
    for first in range(0, beams, step):
        rows = slice(first, first + step)
        part = {name: pixels[rows] for name, pixels in subs.items()}
        echoes = _echoes(part, surfaces, shares, model, weather)
        images = {name: winners(part[name], echoes) for name in _CARRIED}
        if model.panes:
            look_through_panes(echoes, surfaces.transmission, images["primitive"], model, rng)
        scatter_power(echoes, logarithm[rows], surfaces.grain, images["primitive"], model, rng)
        if weather.scatters:
            _blank(images, hang_in_the_air(echoes, model, weather, rng))
        lost = undetected(echoes, patches[rows], model, rng)
        images["intensity"] = intensity(echoes, model)
        rough = roughness(surfaces.relief, images["primitive"], images["incidence"], model)
        images["depth"] = range_noise(echoes, offsets[rows], rough, sensor, model, rng)
        _blank(images, lost)
        for name, pixels in images.items():
            seen[name][rows] = pixels
    return RangeImage.unchecked(sensor, **seen)


def _echoes(
    subs: dict[str, np.ndarray], surfaces: Surfaces, shares: np.ndarray, model: SensorModel, weather: Weather
) -> Echoes:
    """The echoes of some beams, of images [H, S, W] of their sub-rays, which have these shares [S] of the power.

    Where all sub-rays met one surface, its response is that at their mean incidence.
    """
    depth, primitive, incidence = subs["depth"], subs["primitive"], subs["incidence"]
    power = received_power(depth, shares[:, None], model, weather)
    mixed = mixed_pixels(depth, primitive, model.pulse_length)
    rays = rays_of(mixed, depth.shape)
    power.reshape(-1)[rays] *= surfaces.response(primitive.ravel()[rays], incidence.ravel()[rays])
    mean = np.add.reduce(incidence, axis=1)
    mean *= np.float32(1.0 / len(shares))
    response = surfaces.response(primitive[:, 0], mean)
    response.reshape(-1)[mixed] = 1.0
    echoes = receive(depth, power, primitive, pulse_length=model.pulse_length, last=model.last, mixed=mixed)
    echoes.power *= response
    return echoes


def received_power(depth: np.ndarray, response: np.ndarray, model: SensorModel, weather: Weather) -> np.ndarray:
    """Power of echoes f32, 1 being the faintest that are detected (one in e); 0 where there is no return, at depth 0.

    The lidar equation for surfaces that fill the (sub-)beam: response over range squared, less the extinction there and
    back. A model whose `faintest` is 0 detects everything.
    """
    power = np.multiply(depth, depth)
    np.maximum(power, np.float32(1e-6), out=power)
    np.divide(response, power, out=power)
    power *= np.float32(1.0 / _faintest(model))
    if weather.extinction > 0:
        power *= np.exp(np.float32(-2.0 * weather.extinction) * depth)
    return power


def look_through_panes(
    echoes: Echoes, transmission: np.ndarray, primitive: np.ndarray, model: SensorModel, rng: np.random.Generator
) -> None:
    """Let rays that meet glass see, in some places, what is a little behind it, through the pane twice.

    The stronger echo counts: that of the pane, which is faint unless it faces the sensor, or that from behind.
    """
    at = np.flatnonzero(np.take(transmission > 0, primitive.ravel() + 1, mode="clip"))
    if not len(at):
        return
    depth, power = echoes.depth.reshape(-1), echoes.power.reshape(-1)
    through = transmission[primitive.ravel()[at] + 1]
    deeper = depth[at] + np.float32(_BEHIND_DEPTH) * rng.standard_exponential(len(at), np.float32)
    behind = through**2 * np.float32(_BEHIND_RESPONSE) * (rng.random(len(at), np.float32) < _BEHIND_SHARE)
    echo = received_power(deeper, behind, model, Weather())
    better = echo > power[at]
    depth[at[better]], power[at[better]] = deeper[better], echo[better]


def gains(model: SensorModel, patches: np.ndarray) -> np.ndarray:
    """The logarithm of what multiplies each pixel's power but for speckle, f32 [H, W]: beams, texture and stains.

    `patches` [H, W] is `smooth_noise`: the texture of surfaces. Gains of beams and stains on the window belong to the
    unit, not to the scan.
    """
    beams = np.random.default_rng([model.unit, 1]).standard_normal(len(patches)) * model.gain_spread
    logarithm = patches * np.float32(model.texture)
    logarithm += beams.astype(np.float32)[:, None]
    if model.dust:
        stains = smooth_noise(logarithm.shape, np.random.default_rng([model.unit, 2]))
        logarithm -= np.float32(model.dust) * np.maximum(stains - np.float32(_STAINED), np.float32(0))
    return logarithm


def scatter_power(
    echoes: Echoes,
    logarithm: np.ndarray,
    grain: np.ndarray,
    primitive: np.ndarray,
    model: SensorModel,
    rng: np.random.Generator,
) -> None:
    """Multiply the power by the exponential of `logarithm` [H, W], which is overwritten, and of speckle and grain.

    Speckle is the sensor's, from pulse to pulse; `grain` [P + 1] that of the primitive each pixel met. Both are
    independent from pixel to pixel, so one random number stands for both.
    """
    rough = np.square(grain) * np.float32(model.grainy) + np.float32(model.speckle**2)
    if rough.any():
        scatter = np.take(np.sqrt(rough), primitive + 1, mode="clip")
        scatter *= normal(rng, logarithm.shape)
        logarithm += scatter
    np.exp(logarithm, out=logarithm)
    echoes.power *= logarithm


def hang_in_the_air(echoes: Echoes, model: SensorModel, weather: Weather, rng: np.random.Generator) -> np.ndarray:
    """Let the echo of fog, of a drop or a flake take the place of those that are weaker; bool [H, W] where it does."""
    width = (model.divergence_h, model.divergence_v)
    shape = echoes.depth.shape
    aloft = np.zeros(shape, bool)
    for depth, response in (fog_echo(weather, model.pulse_length, shape, rng), first_drop(weather, width, shape, rng)):
        power = received_power(depth, response, model, weather)
        nearer = (power > echoes.power) & ((depth < echoes.depth) | (echoes.depth == 0))
        np.copyto(echoes.depth, depth, where=nearer)
        np.copyto(echoes.power, power, where=nearer)
        aloft |= nearer
    return aloft


def undetected(echoes: Echoes, patches: np.ndarray, model: SensorModel, rng: np.random.Generator) -> np.ndarray:
    """bool [H, W]: where there is no echo, or one that is not detected.

    An echo of power P is lost with 1 - exp(-f / P - chance): as if its power were that of developed speckle, which is
    distributed exponentially. This is how the ground's rays are lost in recordings of a Pandar64, see
    docs/sensor-model.md. The fading f has the mean 1 and follows the `patches` [H, W] of surfaces, so that lost rays
    come in runs.
    """
    survival = np.take(exponential_quantiles(), draws(rng, echoes.power.shape), mode="clip")
    survival -= np.float32(model.chance)
    survival *= echoes.power
    if not model.fading:
        return survival <= 1.0
    fades = patches * np.float32(-model.fading)
    fades -= np.float32(model.fading**2 / 2)
    return survival <= np.exp(fades, out=fades)


def intensity(echoes: Echoes, model: SensorModel) -> np.ndarray:
    """The stored intensity f32 [H, W], 0 to 1: the power on the sensor's scale, as far as that corrects for range."""
    shown = np.square(echoes.depth)
    shown *= echoes.power
    shown *= np.float32(_faintest(model))
    if not math.isinf(model.compensated):
        far = np.square(echoes.depth * np.float32(1.0 / model.compensated))
        far += np.float32(1.0)
        shown /= far
    if model.knee < 1.0:
        bright = np.flatnonzero(shown > 1.0)
        retro = np.log(shown.ravel()[bright]) * np.float32((1.0 - model.knee) / math.log(max(model.full_scale, 1.01)))
        shown *= np.float32(model.knee)
        shown.reshape(-1)[bright] = np.float32(model.knee) + retro
    else:
        shown *= np.float32(1.0 / model.full_scale)
    np.minimum(shown, np.float32(1.0), out=shown)
    if model.levels:
        shown *= np.float32(model.levels)
        np.rint(shown, out=shown)
        shown *= np.float32(1.0 / model.levels)
    return shown


def range_offsets(model: SensorModel, beams: int) -> np.ndarray:
    """By how much the range of each beam of this unit is wrong, f32 [H], m."""
    drawn = np.random.default_rng([model.unit, 0]).standard_normal(beams) * model.offset_spread
    return drawn.astype(np.float32)


def roughness(relief: np.ndarray, primitive: np.ndarray, incidence: np.ndarray, model: SensorModel) -> np.ndarray:
    """Variance f32 [H, W] of ranges to surfaces whose heights vary by `relief` [P + 1] (m).

    Along the ray it is the height over the cosine of incidence, but for grazing rays, which meet the tops.
    """
    if not model.grainy:
        return np.zeros(primitive.shape, np.float32)
    heights = np.take(relief, primitive + 1, mode="clip")
    heights /= np.maximum(incidence, np.float32(_GRAZING))
    return np.square(heights, out=heights)


def range_noise(
    echoes: Echoes, offsets: np.ndarray, rough: np.ndarray, sensor: Sensor, model: SensorModel, rng: np.random.Generator
) -> np.ndarray:
    """Measured ranges f32 [H, W]: with the beams' `offsets` [H], Gaussian noise, rounded, within the sensor's limits.
    The variance is that of the surface, `rough` [H, W], and of the timing.

    The timing error of a pulse grows with the inverse root of its signal-to-noise ratio (Jutzi and Stilla, ISPRS 2006),
    here from `range_sigma` of strong echoes by `jitter` at the threshold.
    """
    depth = echoes.depth + offsets[:, None]
    if sensor.range_sigma or model.jitter or model.grainy:
        sigma = np.maximum(echoes.power, np.float32(1.0))
        np.divide(np.float32(model.jitter**2), sigma, out=sigma)
        sigma += np.float32(sensor.range_sigma**2)
        sigma += rough
        np.sqrt(sigma, out=sigma)
        sigma *= normal(rng, depth.shape)
        depth += sigma
    if model.range_step:
        depth *= np.float32(1.0 / model.range_step)
        np.rint(depth, out=depth)
        depth *= np.float32(model.range_step)
    np.maximum(depth, np.float32(sensor.min_range), out=depth)
    return np.minimum(depth, np.float32(sensor.max_range), out=depth)


def _faintest(model: SensorModel) -> float:
    """The response over range squared of power 1; where everything is detected, one that nothing is below."""
    return model.faintest or 1e-12


def _blank(images: dict[str, np.ndarray], where: np.ndarray) -> None:
    """Write what stands for no return, or for a return of nothing that the layout has."""
    for name, image in images.items():
        np.copyto(image, image.dtype.type(-1 if name == "primitive" else 0), where=where)
