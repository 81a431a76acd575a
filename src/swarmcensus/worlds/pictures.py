"""Pictures: the grey levels of PNG and JPEG files, for floors."""

import hashlib
import io
import math
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, ValidationInfo

from swarmcensus.support.errors import InputError
from swarmcensus.support.files import content

MOST_PIXELS = 1 << 24
MOST_BYTES = 200_000_000


@dataclass(frozen=True)
class Picture:
    """The grey levels of an image file: (row, column), the top row first, 0 black to 65535 white."""

    name: str
    digest: str  # of the grey levels: random numbers depend on it, and not on the file's path
    source: str = field(compare=False)  # the path, as in the study file
    grey: np.ndarray = field(compare=False, repr=False)

    def __str__(self) -> str:
        """As in the dataset."""
        return self.name


def _picture(value: object, info: ValidationInfo) -> Picture:
    if isinstance(value, Picture):
        return value
    if not isinstance(value, str):
        raise ValueError("an image is the path of a PNG or JPEG file")
    context = info.context or {}
    base: Path | None = context.get("base")
    if value in (known := context.get("images", {})):
        pixels = known[value]
    elif base is None:
        raise ValueError("this image is not stored here, and no file is opened here")
    else:
        pixels = read_image(base / value)
    grey = np.ascontiguousarray(pixels, "<u2")
    digest = hashlib.blake2b(repr(grey.shape).encode() + grey.tobytes(), digest_size=16).hexdigest()
    return Picture(Path(value).stem, digest, value, grey)


# a key that names an image, looked for in the study's results, then in the study's folder
PictureFile = Annotated[Picture, BeforeValidator(_picture)]


def read_image(path: Path) -> np.ndarray:
    """The grey levels (row, column) of a PNG or JPEG file, 0 black to 65535 white. Raises InputError.

    Colours become luma (ITU-R BT.601); transparent pixels are laid over white.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError  # imported only for pictures

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # the size is checked below
            found = content(path, MOST_BYTES)
            with Image.open(io.BytesIO(found), formats=["PNG", "JPEG"]) as image:
                if math.prod(image.size) > MOST_PIXELS:
                    size = f"{image.width:,} x {image.height:,} pixels"
                    raise _error(path, f"{size}: should be {MOST_PIXELS:,} at the most")
                bits, kind = found[24:26] if image.format == "PNG" else (8, 0)  # 0 is grey alone
                if (bits == 16 and kind) or (image.format == "PNG" and getattr(image, "n_frames", 1) > 1):
                    raise _error(path, "should be one picture, of 8 bits, or of 16 in grey alone")
                if bits < 8 and not kind and "transparency" in image.info:  # Pillow scales the other greys alone
                    image.info["transparency"] *= 255 // (2**bits - 1)
                return _grey(image if image.format == "PNG" else ImageOps.exif_transpose(image))  # as viewers turn it
    except FileNotFoundError:
        raise _error(path, "there is no such file") from None
    except UnidentifiedImageError:
        raise _error(path, "not a PNG or JPEG file") from None
    except Image.DecompressionBombError:
        raise _error(path, f"too many pixels: should be {MOST_PIXELS:,} at the most") from None
    except InputError:
        raise
    except (OSError, SyntaxError, ValueError, EOFError) as error:  # Pillow's errors for damaged files
        raise _error(path, f"cannot be read: {getattr(error, 'strerror', None) or error}") from error


def _error(path: Path, what: str) -> InputError:
    return InputError.of(path, what, where=f"image {path}")


def _grey(image: Any) -> np.ndarray:
    if image.mode.startswith("I"):  # 16 bits
        grey = np.asarray(image).astype(np.uint16)
        clear = image.info.get("transparency")
        return grey if clear is None else np.where(grey == clear, np.uint16(65535), grey)
    if image.has_transparency_data:
        from PIL import Image

        image = image.convert("RGBA")
        image = Image.alpha_composite(Image.new("RGBA", image.size, "white"), image)
    return np.asarray(image.convert("L")).astype(np.uint16) * np.uint16(257)
