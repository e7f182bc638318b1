"""Types that several modules use."""
from dataclasses import dataclass
from typing import Any

import numpy.typing

Array = numpy.typing.NDArray[Any]


@dataclass(frozen=True)
class Label:
    """What a client says of a feature, for its own use: the mesh does not depend on it."""

    marker: int = 0  #: 0: none.
    name: str = ""  #: Empty: none. At most 255 bytes of UTF-8, without control characters.
