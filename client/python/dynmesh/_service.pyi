# The extension module: untyped here, its users are typed.
from typing import Any

def __getattr__(name: str) -> Any: ...
