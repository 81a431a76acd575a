"""What a floor looks like: independent tiles, clusters, stripes, one half, or a picture."""

import hashlib
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, UnidentifiedImageError

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean

LENGTHS = ("clusters", "stripes")  # kinds of floor that have a length
MODES = ("threshold", "dither")
LONGEST = 1000.0  # metres
MOST_PIXELS = 1 << 24
FORMS = (
    'one of "tiles", "half", {clusters = 0.2}, {stripes = 0.5} (metres) and '
    '{image = "leaves.png", mode = "threshold"} (or "dither")'
)


@dataclass(frozen=True)
class Picture:
    """The grey levels of an image file: (row, column), the top row first, 0 black to 65535 white."""

    name: str
    digest: str  # of the grey levels: what random numbers depend on, wherever the file lies
    source: str = field(compare=False)  # the path, as in the study file
    grey: np.ndarray = field(compare=False, repr=False)


@dataclass(frozen=True)
class Floor:
    """A kind of floor; `length` in metres is the clusters' correlation length or the stripes' period."""

    kind: str = "tiles"
    length: float = 0.0
    picture: Picture | None = None
    mode: str = ""

    def __str__(self) -> str:
        """As in the dataset: "tiles", "clusters(0.2)", "stripes(0.5)", "half", "image(leaves)"."""
        if self.picture is not None:
            return f"image({self.picture.name}{'' if self.mode == MODES[0] else ',' + self.mode})"
        return f"{self.kind}({self.length:.12g})" if self.kind in LENGTHS else self.kind

    @property
    def content(self) -> object:
        """What the random numbers of this floor depend on."""
        return [self.kind, self.length, self.picture and self.picture.digest, self.mode]

    @property
    def form(self) -> object:
        """As in a study file."""
        if self.picture is not None:
            return {"image": self.picture.source, "mode": self.mode}
        return {self.kind: self.length} if self.kind in LENGTHS else self.kind

    def check(self, tile: float) -> None:
        """Raise ValueError where tiles of this side cannot show the floor."""
        if self.kind == "clusters" and self.length < 2.0 * tile:
            raise ValueError(
                f"world.floor = {{clusters = {self.length:g}}}: should be at least two tiles, {2.0 * tile:g} m; "
                'without clusters the floor is "tiles"'
            )


def parse_floor(value: object, base: Path | None, known: Mapping[str, np.ndarray]) -> Floor:
    """Read any form of floor that a study may hold. Raises ValueError or InputError with what would be right.

    Image files are looked for in `known` (path to grey levels) first, then below `base`; without it none is opened.
    """
    if isinstance(value, Floor):
        return value
    if value in ("tiles", "half"):
        return Floor(str(value))
    if isinstance(value, Mapping) and len(value) == 1 and next(iter(value)) in LENGTHS:
        ((kind, length),) = value.items()
        number = isinstance(length, int | float) and not isinstance(length, bool)
        if not number or not 0.0 < length <= LONGEST:
            raise ValueError(f"{kind} have a length in metres, above 0 and at most {LONGEST:g}")
        return Floor(kind, float(length))
    if isinstance(value, Mapping) and "image" in value and set(value) <= {"image", "mode"}:
        mode, source = value.get("mode", MODES[0]), value["image"]
        if mode not in MODES:
            raise ValueError(f"{did_you_mean(str(mode), MODES)}the mode of an image is one of {', '.join(MODES)}")
        if not isinstance(source, str):
            raise ValueError("an image is the path of a PNG file")
        if source not in known and base is None:
            raise ValueError("this image is not here, and no file is opened that is only named here")
        grey = known[source] if source in known else read_image(base / source)  # type: ignore[operator]
        grey = np.ascontiguousarray(grey, "<u2")
        digest = hashlib.blake2b(repr(grey.shape).encode() + grey.tobytes(), digest_size=16).hexdigest()
        return Floor("image", picture=Picture(Path(source).stem, digest, source, grey), mode=mode)
    meant = value if isinstance(value, str) else " ".join(map(str, value)) if isinstance(value, Mapping) else ""
    raise ValueError(f"{did_you_mean(meant, ('tiles', 'half', *LENGTHS, 'image'))}a floor is {FORMS}")


def read_image(path: Path) -> np.ndarray:
    """The grey levels (row, column) of a PNG file, 0 black to 65535 white. Raises InputError.

    Colours become luma (ITU-R BT.601), what is transparent is seen over white.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # the size is looked at below
            with Image.open(path, formats=["PNG"]) as image:
                if math.prod(image.size) > MOST_PIXELS:
                    size = f"{image.width:,} x {image.height:,} pixels"
                    raise InputError(f"image {path}: {size}: should be {MOST_PIXELS:,} at the most")
                return _grey(image)
    except FileNotFoundError:
        raise InputError(f"image {path}: there is no such file") from None
    except UnidentifiedImageError:
        raise InputError(f"image {path}: not a PNG file") from None
    except Image.DecompressionBombError:
        raise InputError(f"image {path}: too many pixels: should be {MOST_PIXELS:,} at the most") from None
    except (OSError, SyntaxError, ValueError, EOFError) as error:  # what Pillow makes of damaged files
        if isinstance(error, InputError):
            raise
        raise InputError(f"image {path}: cannot be read as PNG: {error}") from error


def _grey(image: Any) -> np.ndarray:
    if image.mode.startswith("I"):  # 16 bits
        grey = np.asarray(image).astype(np.uint16)
        clear = image.info.get("transparency")
        return grey if clear is None else np.where(grey == clear, np.uint16(65535), grey)
    if image.has_transparency_data:
        image = image.convert("RGBA")
        image = Image.alpha_composite(Image.new("RGBA", image.size, "white"), image)
    return np.asarray(image.convert("L")).astype(np.uint16) * np.uint16(257)
