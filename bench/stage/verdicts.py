"""What an evening on stage must show, by its report (evening.py)."""

# Memory at rest, and the median pause between two frames of a quarter of the time, may grow by so much.
MEMORY_SHARE, FRAME_SHARE = 0.02, 0.15
# So long after a sound device is back, a gap is that of its absence.
SETTLED_SECS = 3.0


def surprises(underruns, absences):
    """How often a device that was there had nothing to play. Of both, times in seconds since 1970.

    >>> surprises([[9.0, 1], [11.0, 2], [17.5, 4], [18.5, 8]], [(10.0, 15.0)])
    9
    """
    missed = lambda at: any(gone <= at <= back + SETTLED_SECS for gone, back in absences)  # noqa: E731
    return sum(count for at, count in underruns if not missed(at))


def verdicts(report):
    """Sentences, and whether each is as it should be. The first rest comes before all has been used once, so the second is
    what the later ones are measured by.

    >>> rests = [(90, 20, 9), (100, 22, 12), (101.9, 22, 12)]
    >>> quarters = {"median_quarters_secs": [0.02, 0.022, 0.02, 0.0], "surprises": 0}
    >>> shown = {"asked": 3, "opened": 3, "followed": 1}
    >>> [good for _, good in verdicts({"rests": rests, **quarters, **shown})]
    [True, True, True, True, True, True, True]
    >>> rests = [(90, 20, 9), (100, 22, 12), (97, 23, 13)]
    >>> quarters = {"median_quarters_secs": [0.02, 0.02, 0.03, 0.02], "surprises": 2}
    >>> shown = {"asked": 3, "opened": 2, "followed": 0}
    >>> [good for _, good in verdicts({"rests": rests, **quarters, **shown})]
    [False, False, False, False, False, False, False]
    """
    found = []
    later = report["rests"][1:]
    memory, files, threads = zip(*later) if later else ([], [], [])
    whole = len(later) > 1
    away = max((abs(mb / memory[0] - 1.0) for mb in memory), default=0.0)
    found.append((f"memory at rest is up to {100 * away:.1f} % from the second rest's", whole and away <= MEMORY_SHARE))
    for name, counts in [("open files", files), ("threads", threads)]:
        words = f"{name} at rest: {', '.join(map(str, counts))}"
        found.append((words, whole and max(counts) <= counts[0]))
    first, *others = report["median_quarters_secs"]
    slower = max(others) / first - 1.0 if first > 0.0 else float("inf")
    words = f"the median frame of the slowest later quarter is {100 * slower:+.0f} % from the first's"
    found.append((words, slower <= FRAME_SHARE))
    words = f"a device that was there had nothing to play {report['surprises']} times"
    found.append((words, report["surprises"] == 0))
    words = f"{report['opened']} of {report['asked']} shapes opened are named by the show's log"
    found.append((words, report["opened"] == report["asked"]))
    words = f"{report['followed']} songs began because the one before had ended"
    found.append((words, report["followed"] > 0))
    return found
