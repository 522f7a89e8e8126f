"""What `chladni dance --json` says of a film."""


def filming_secs(report):
    """Seconds that grow with the film's length: without reading, stance and mirror plane of the shape, and the song's beats."""
    seconds = report["seconds"]
    # Spectra and mapping are made anew for each frame.
    start = ("reading", "preparing", "beats")
    return seconds["total"] - sum(seconds[part] for part in start)
