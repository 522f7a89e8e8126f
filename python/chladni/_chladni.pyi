# The compiled part: its names are not for users.
from typing import Any

def __getattr__(name: str) -> Any: ...
