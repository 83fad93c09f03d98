"""Tubes to a lit picture: lamp, shadows, ambient occlusion, and the paper they lie on."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .tubes import Canvas, rasterise

Array = NDArray[Any]

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
    depths: list[Array]  # of all tubes, then of the thick alone where others are much thinner
    radii: list[float]   # of those that take light away in each
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
    radii = [thin, thick] if thick > 2 * thin else [thin]
    reach = -(-int(np.ceil(9 * radii[-1]) + 1) // sampling) * sampling
    band = max(8, int(MOST_SAMPLES / (width * sampling) / sampling) - 2 * reach // sampling)
    picture = np.empty((height, width, 3), np.float32)
    for low in range(0, height, band):
        high = min(low + band, height)
        corner = np.array([-reach, low * sampling - reach])
        shift = np.append(corner, 0)
        canvas = Canvas(width * sampling + 2 * reach, (high - low) * sampling + 2 * reach)
        depth, owner, normal = seen(scene, shift, canvas)
        # Steps as long as a thick tube asks for would miss thin ones here and there.
        depths = [depth] + [seen(scene, shift, canvas, 0.5 * scene.radii[1])[0] for _ in radii[1:]]
        layers = Layers(depths, radii, owner, normal, reach, corner[1])
        picture[low:high] = shade(scene, layers, sampling)
    if scene.radii[0] < 1.5 * sampling:
        picture = soften(picture)
    return np.asarray(np.minimum(picture[::-1], 1) ** np.float32(1 / 2.2))


def seen(scene: Scene, shift: Array, canvas: Canvas,
         least: float = 0) -> tuple[Array, Array, Array]:
    """Depth, tube and normal at each sample, of the tubes of at least this radius."""
    rows = np.flatnonzero(scene.radius >= least)
    tangent = scene.tangent[0][rows], scene.tangent[1][rows]
    return rasterise(scene.a[rows] - shift, scene.b[rows] - shift, tangent, scene.radius[rows],
                     canvas)


def soften(picture: Array, share: float = 0.14) -> Array:
    """Tubes about as wide as a pixel beat with the grid of pixels unless they reach a little into
    the neighbours."""
    for axis in 0, 1:
        before = np.concatenate([picture.take([0], axis),
                                 picture.take(range(picture.shape[axis] - 1), axis)], axis)
        after = np.concatenate([picture.take(range(1, picture.shape[axis]), axis),
                                picture.take([-1], axis)], axis)
        picture = (1 - 2 * share) * picture + share * (before + after)
    return picture


class Above(NamedTuple):
    """What stands around each sample."""
    rise: Callable[[float, float], Array]  # x and y aside, above the sample
    radius: float
    phase: float  # 0 to 1: of the directions and steps in which this sample looks


def occlusion(above: Above, normal: tuple[Array, Array, Array]) -> Array:
    """Share of the sky, 0 to 0.8, that is closed by what rises above the tangent plane."""
    nx, ny, nz = normal
    closed = np.zeros_like(nz)
    for ring, directions in ((1.4, 5), (3.0, 5), (6.0, 6)):
        for angle in (np.arange(directions) + above.phase + ring) * 2 * np.pi / directions:
            x, y = ring * above.radius * np.cos(angle), ring * above.radius * np.sin(angle)
            z = above.rise(x, y)
            sine = (nx * x + ny * y + nz * z) / np.sqrt(x * x + y * y + z * z)
            closed += np.clip(sine - np.float32(0.1), 0, 0.8) / 16
    return closed


def shadowed(above: Above) -> Array:
    """Shadow, 0 to 1, of what stands in the way to the light, softer with distance."""
    radius, shadow = above.radius, np.float32(0)
    for step in radius * (0.5 + np.arange(8) + above.phase):
        way = (above.rise(LAMP[0] / FLAT * step, LAMP[1] / FLAT * step)
               - np.float32(LAMP[2] / FLAT * step))
        # Tubes have an underside: light passes below those that are far above.
        way = np.minimum(way, 4.5 * radius - way)
        shadow = np.maximum(shadow, np.clip(way / (0.2 * radius + 0.2 * step), 0, 1))
    return np.asarray(shadow)


def shade(scene: Scene, layers: Layers, sampling: int) -> Array:
    """The lit inner part of the layers."""
    depths, radii, owner, normal, reach, bottom = layers
    height, width = (side - 2 * reach for side in owner.shape)
    y = np.arange(owner.shape[0], dtype=np.float32)[:, None] + np.float32(bottom)
    plane = np.float32(scene.level) + np.float32(scene.tilt) * y
    depths = [np.where(depth > -np.inf, depth, plane) for depth in depths]
    steep = 1 / np.sqrt(1 + scene.tilt ** 2)
    normal[1][owner < 0] = -scene.tilt * steep
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

        here, tube, nx, ny = part(depths[0]), part(owner), part(normal[0]), part(normal[1])
        hit = tube >= 0
        nz = np.sqrt(np.maximum(1 - nx * nx - ny * ny, 0))
        closed, shadow = np.zeros_like(here), np.zeros_like(here)
        for depth, radius in zip(depths, radii):
            def rise(x: float, y: float, depth: Array = depth) -> Array:
                return part(depth, x, y) - here

            above = Above(rise, radius, phase)
            np.maximum(closed, occlusion(above, (nx, ny, nz)), out=closed)
            np.maximum(shadow, shadowed(above), out=shadow)
        ambient = np.exp(-4 * strength * closed)
        lamp = ((1 - 0.85 * strength * shadow)
                * np.maximum(nx * LAMP[0] + ny * LAMP[1] + nz * LAMP[2], 0))
        gloss = np.maximum(nx * HALF[0] + ny * HALF[1] + nz * HALF[2], 0) ** 40 * (1 - shadow)
        diffuse = ambient * (0.40 + 0.1 * ny) + 0.85 * lamp * (0.4 + 0.6 * ambient)
        lit = scene.albedo[tube] * diffuse[..., None] + (0.14 * gloss * ambient)[..., None]
        ground = scene.paper * ((0.6 + 0.4 * ambient) * (1 - 0.4 * strength * shadow))[..., None]
        result += np.where(hit[..., None], np.minimum(lit, 1), ground)
    return np.asarray(picture / sampling ** 2)
