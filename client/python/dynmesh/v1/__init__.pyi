# Modules that protoc makes: untyped here, their users are typed.
from typing import Any

def __getattr__(name: str) -> Any: ...
