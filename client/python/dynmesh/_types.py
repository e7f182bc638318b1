"""Type aliases."""
from typing import Any

import numpy.typing

Array = numpy.typing.NDArray[Any]
