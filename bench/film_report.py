"""What `chladni dance --json` says of a film."""


def filming_secs(report):
    """Seconds that grow with the film's length: without reading, stance and mirror plane of the shape, and hearing the song."""
    seconds = report["seconds"]
    start = ("reading", "preparing", "beats", "analysis", "mapping")
    return seconds["total"] - sum(seconds[part] for part in start)
