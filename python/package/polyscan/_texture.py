"""Textures: pictures that are sampled at coordinates, or over what a pixel sees of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _polyscan

#: Mitchell and Netravali's parameters (B, C) of bicubic filters.
_CUBICS = {"b-spline": (1.0, 0.0), "catmull-rom": (0.0, 0.5), "mitchell": (1 / 3, 1 / 3)}


class Texture:
    """A picture that is sampled, with its smaller versions.

    Texture coordinates have u to the right and v DOWN: (0, 0) is the top left corner of the picture, whose first row is its
    top, (1, 1) the bottom right one. Turn the v of OBJ files and of OpenGL around: `1 - v`.

    Texels are filtered as linear light, premultiplied by alpha.
    """

    def __init__(
        self,
        picture: npt.ArrayLike,
        *,
        colors: str = "auto",
        filter: str = "bilinear",
        mip_filter: str = "anisotropic",
        most: int = 16,
        wrap: str | tuple[str, str] = "repeat",
        border: npt.ArrayLike = (0.0, 0.0, 0.0, 0.0),
        level_bias: float = 0.0,
        level_range: tuple[float, float] = (0.0, 100.0),
    ) -> None:
        """
        picture: (height, width) or (height, width, c) with 1 (grey), 2 (grey, alpha), 3 or 4 (with alpha) channels; u8, u16,
            f16 or f32. f64 is taken as f32. A copy is kept.
        colors: "srgb" if whole numbers are codes of sRGB with straight alpha, "linear" if they are numbers from 0 to 1;
            "auto" is "srgb" for whole numbers. Floats are taken as they stand: linear, premultiplied.
        filter: where the picture is magnified: "nearest", "bilinear", "b-spline", "catmull-rom" or "mitchell".
        mip_filter: where it is made smaller, if `sample` is given derivatives: "off", "nearest" level, "linear" (trilinear),
            "anisotropic", or "ewa" (Heckbert 1989).
        most: the most probes of "anisotropic", the greatest eccentricity of "ewa", from 1 to 64.
        wrap: outside of 0 to 1: "repeat", "clamp", "mirror" or "border"; or a pair for u and v.
        border: the colour (r, g, b, a) for "border": linear light, premultiplied.
        level_bias: added to the level of detail: above 0 for a blurred picture.
        level_range: the least and the greatest level of detail.
        """
        pixels = arguments.array("picture", picture)
        if pixels.ndim == 2:
            pixels = pixels[..., None]
        if pixels.ndim != 3 or not 1 <= pixels.shape[2] <= 4 or 0 in pixels.shape:
            raise ValueError(f"picture must have the shape (height, width) or (height, width, 1 to 4), not {pixels.shape}")
        pixels, kind = _stored(pixels, colors)
        names = (wrap, wrap) if isinstance(wrap, str) else wrap
        if not isinstance(names, (tuple, list)) or len(names) != 2:
            raise ValueError(f"wrap must be a name or a pair of names, not {wrap!r}")
        filters = ("nearest", "bilinear", *_CUBICS)
        chosen = arguments.one_of("filter", filter, filters)
        least, greatest = _pair("level_range", level_range)
        how: dict[str, Any] = {
            "filter": "bicubic" if chosen in _CUBICS else chosen,
            "cubic": _CUBICS.get(chosen, (0.0, 0.0)),
            "mip_filter": arguments.one_of("mip_filter", mip_filter, ("off", "nearest", "linear", "anisotropic", "ewa")),
            "most": arguments.whole("most", most, 1, 64),
            "wrap": tuple(arguments.one_of("wrap", name, ("repeat", "clamp", "mirror", "border")) for name in names),
            "border": arguments.finite("border", border, (4,)).tolist(),
            "level_bias": arguments.number("level_bias", level_bias),
            "level_range": (least, greatest),
        }
        self._texture = _polyscan.Texture(np.ascontiguousarray(pixels), kind, how)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in texels."""
        return self._texture.size

    @property
    def channels(self) -> int:
        return self._texture.channels

    def sample(
        self, uv: npt.ArrayLike, derivatives: npt.ArrayLike | None = None, *, threads: int | None = None
    ) -> npt.NDArray[np.float32]:
        """Colours at texture coordinates.

        uv: (..., 2). NaN and infinities count as 0.
        derivatives: (..., 2, 2), as `interpolate` returns them: of u and then v, per pixel to the right and downwards. With
            them the picture is filtered over what each pixel sees.

        Returns (..., channels) f32: linear light, premultiplied by alpha.
        """
        points = arguments.floats32("uv", uv)
        if points.ndim == 0 or points.shape[-1] != 2:
            raise ValueError(f"uv must have the shape (..., 2), not {points.shape}")
        shape = points.shape[:-1]
        sides = None
        if derivatives is not None:
            sides = arguments.floats32("derivatives", derivatives)
            if sides.shape != (*shape, 2, 2):
                raise ValueError(f"derivatives must have the shape {(*shape, 2, 2)}, not {sides.shape}")
            sides = sides.reshape(-1)
        out = np.empty((*shape, self.channels), np.float32)
        self._texture.sample(points.reshape(-1), sides, out.reshape(-1), arguments.threads(threads))
        return out


def texture(
    picture: Texture | npt.ArrayLike,
    uv: npt.ArrayLike,
    derivatives: npt.ArrayLike | None = None,
    *,
    threads: int | None = None,
    **how: Any,
) -> npt.NDArray[np.float32]:
    """Colours of a picture at texture coordinates: `Texture(picture, **how).sample(uv, derivatives)`.

    Make a `Texture` to use a picture more than once.
    """
    if isinstance(picture, Texture):
        if how:
            raise ValueError(f"{', '.join(how)} belong to the Texture, which is made already")
        return picture.sample(uv, derivatives, threads=threads)
    return Texture(picture, **how).sample(uv, derivatives, threads=threads)


def _stored(pixels: np.ndarray, colors: str) -> tuple[np.ndarray, str]:
    """Pixels as the library keeps them, and as what."""
    chosen = arguments.one_of("colors", colors, ("auto", "srgb", "linear"))
    if pixels.dtype in (np.uint8, np.uint16):
        bits = 8 * pixels.dtype.itemsize
        native = pixels.astype(pixels.dtype.newbyteorder("="), copy=False)
        return native, f"unorm{bits}" if chosen == "linear" else f"srgb{bits}"
    if chosen == "srgb":
        raise ValueError(f"colors are linear in a picture of {pixels.dtype}: give u8 or u16 for sRGB")
    if pixels.dtype == np.float16:
        return np.ascontiguousarray(pixels).view(np.uint16), "f16"
    if pixels.dtype.kind != "f":
        raise ValueError(f"picture must be of u8, u16, f16, f32 or f64, not {pixels.dtype}")
    return pixels.astype(np.float32, copy=False), "f32"


def _pair(name: str, value: Any) -> tuple[float, float]:
    try:
        first, second = value
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a pair of numbers, not {value!r}") from None
    return arguments.number(f"{name}[0]", first), arguments.number(f"{name}[1]", second)
