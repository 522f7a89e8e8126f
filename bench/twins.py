"""What the example `twins` of chladni-view prints: both renderers on the same pictures."""


def read(printed):
    """Names of the devices, the lines of counts, and the Markdown table, line by line."""
    lines = printed.splitlines()
    counts = [line for line in lines if line.startswith("counts:")]
    head, *rows = [line for line in lines if line.startswith("|")]
    devices = [line for line in lines if not line.startswith(("|", "counts:"))]
    return devices, counts, [head, "|" + "---|" * (head.count("|") - 1), *rows]
