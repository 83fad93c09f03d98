"""Tubes to a lit picture: lamp, shadows, ambient occlusion, and the paper they lie on."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .tubes import Canvas, rasterise

Array = NDArray[Any]
Shifted = Callable[..., Array]  # a layer as seen by samples that lie x and y aside

LAMP = np.array([-0.50, 0.60, 0.85]) / np.linalg.norm([-0.50, 0.60, 0.85])
HALF = (LAMP + [0, 0, 1]) / np.linalg.norm(LAMP + [0, 0, 1])
FLAT = np.hypot(LAMP[0], LAMP[1])
MOST_SAMPLES = 1.2e7  # at a time; each takes about 40 bytes


class Scene(NamedTuple):
    """Tubes in samples, z towards the viewer, and the plane z = level + tilt y behind them."""
    a: Array
    b: Array
    tangent: tuple[Array, Array]
    radius: Array
    albedo: Array  # linear, as is `paper`
    paper: Array
    radii: tuple[float, float]  # the thinnest and the thickest
    level: float
    tilt: float


class Layers(NamedTuple):
    """What is seen at each sample; they reach further than the picture by `reach` on all sides."""
    depth: Array
    owner: Array
    normal: Array
    reach: int
    bottom: float  # y of the lowest row


def linear(colour: ArrayLike) -> Array:
    """Light adds up linearly; colours and pictures are in sRGB."""
    return np.asarray(np.asarray(colour, np.float32) ** np.float32(2.2))


def draw(scene: Scene, width: int, height: int, sampling: int) -> Array:
    """The picture in sRGB, top row first, each pixel the mean of sampling x sampling samples."""
    # A close-up need not look far around each sample.
    thin, thick = (min(radius, 40.0) for radius in scene.radii)
    scales = (thin,) if thick < 2 * thin else (thin, thick)
    reach = -(-int(np.ceil(9 * scales[-1]) + 1) // sampling) * sampling
    band = max(8, int(MOST_SAMPLES / (width * sampling) / sampling) - 2 * reach // sampling)
    picture = np.empty((height, width, 3), np.float32)
    for low in range(0, height, band):
        high = min(low + band, height)
        corner = np.array([-reach, low * sampling - reach])
        shift = np.append(corner, 0)
        canvas = Canvas(width * sampling + 2 * reach, (high - low) * sampling + 2 * reach)
        layers = Layers(*rasterise(scene.a - shift, scene.b - shift, scene.tangent, scene.radius, canvas),
                        reach, corner[1])
        picture[low:high] = shade(scene, layers, scales, sampling)
    if scene.radii[0] < 1.5 * sampling:
        picture = soften(picture)
    return np.asarray(np.minimum(picture[::-1], 1) ** np.float32(1 / 2.2))


def soften(picture: Array, share: float = 0.14) -> Array:
    """Tubes about as wide as a pixel beat with the grid of pixels unless they reach a little into
    the neighbours."""
    for axis in 0, 1:
        before = np.concatenate([picture.take([0], axis), picture.take(range(picture.shape[axis] - 1), axis)], axis)
        after = np.concatenate([picture.take(range(1, picture.shape[axis]), axis), picture.take([-1], axis)], axis)
        picture = (1 - 2 * share) * picture + share * (before + after)
    return picture


def occlusion(depth: Shifted, normal: tuple[Array, Array, Array], radius: float,
              phase: float) -> Array:
    """Share of the sky, 0 to 0.8, that is closed by what rises above the tangent plane."""
    here = depth()
    nx, ny, nz = normal
    closed = np.zeros_like(here)
    for ring, directions in ((1.4, 5), (3.0, 5), (6.0, 6)):
        for angle in (np.arange(directions) + phase + ring) * 2 * np.pi / directions:
            x, y = ring * radius * np.cos(angle), ring * radius * np.sin(angle)
            z = depth(x, y) - here
            sine = (nx * x + ny * y + nz * z) / np.sqrt(x * x + y * y + z * z)
            closed += np.clip(sine - np.float32(0.1), 0, 0.8) / 16
    return closed


def cast_shadow(shadow: Array, depth: Shifted, radius: float, phase: float) -> None:
    """Deepens the shadow by what stands in the way to the light, softer with distance."""
    here = depth()
    for step in radius * (0.5 + np.arange(8) + phase):
        way = (depth(LAMP[0] / FLAT * step, LAMP[1] / FLAT * step) - here
               - np.float32(LAMP[2] / FLAT * step))
        # Tubes have an underside: light passes below those that are far above.
        way = np.minimum(way, 4.5 * radius - way)
        np.maximum(shadow, np.clip(way / (0.2 * radius + 0.2 * step), 0, 1), out=shadow)


def shade(scene: Scene, layers: Layers, scales: tuple[float, ...], sampling: int) -> Array:
    """The lit inner part of the layers; scales: radii of the tubes, as far as they differ much."""
    depth, owner, normal, reach, bottom = layers
    height, width = (side - 2 * reach for side in depth.shape)
    seen = owner >= 0
    y = np.arange(depth.shape[0], dtype=np.float32)[:, None] + np.float32(bottom)
    depth = np.where(seen, depth, np.float32(scene.level) + np.float32(scene.tilt) * y)
    steep = 1 / np.sqrt(1 + scene.tilt ** 2)
    normal[1][~seen] = -scene.tilt * steep
    # On tubes of a pixel or two, shading as deep as on thick ones would only grey the colours.
    strength = np.float32(np.clip(0.4 * scene.radii[0] / sampling, 0.6, 1))

    picture = np.zeros((height // sampling, width // sampling, 3), np.float32)
    # Each of the samples averaged into one pixel looks in other directions: few samples look like
    # many. Strips fit the cache, since every sample passes over all their arrays.
    strip = 48
    for sub, top in np.ndindex(sampling ** 2, -(-len(picture) // strip)):
        phase = (sub + 0.5) / sampling ** 2
        result = picture[strip * top:strip * (top + 1)]
        row = reach + sampling * strip * top + sub // sampling
        column = reach + sub % sampling

        def part(layer: Array, x: Any = 0, y: Any = 0) -> Array:
            x, y = column + round(x), row + round(y)
            return layer[y:y + sampling * len(result):sampling, x:x + width:sampling][:len(result)]

        here, tube, nx, ny = part(depth), part(owner), part(normal[0]), part(normal[1])
        hit = tube >= 0
        nz = np.sqrt(np.maximum(1 - nx * nx - ny * ny, 0))
        closed, shadow = np.zeros_like(here), np.zeros_like(here)
        around = functools.partial(part, depth)
        for radius in scales:
            np.maximum(closed, occlusion(around, (nx, ny, nz), radius, phase), out=closed)
            cast_shadow(shadow, around, radius, phase)
        ambient = np.exp(-4 * strength * closed)
        lamp = (1 - 0.85 * strength * shadow) * np.maximum(nx * LAMP[0] + ny * LAMP[1] + nz * LAMP[2], 0)
        gloss = np.maximum(nx * HALF[0] + ny * HALF[1] + nz * HALF[2], 0) ** 40 * (1 - shadow)
        diffuse = ambient * (0.40 + 0.1 * ny) + 0.85 * lamp * (0.4 + 0.6 * ambient)
        lit = scene.albedo[tube] * diffuse[..., None] + (0.14 * gloss * ambient)[..., None]
        ground = scene.paper * ((0.6 + 0.4 * ambient) * (1 - 0.4 * strength * shadow))[..., None]
        result += np.where(hit[..., None], np.minimum(lit, 1), ground)
    return np.asarray(picture / sampling ** 2)
