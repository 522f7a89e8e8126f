"""Reads the camera Chladni from PipeWire for some seconds: how many pictures come, how many differ, and how evenly."""

import json
import subprocess
import sys
import time

WIDTH, HEIGHT = 160, 100
PIPELINE = (
    f"pipewiresrc target-object=chladni ! videoconvert ! videoscale ! video/x-raw,format=RGB,width={WIDTH},"
    f"height={HEIGHT} ! fdsink fd=1 sync=false"
)


def frames(seconds):
    """The pictures of `seconds` from the first one on, each with its time; a reader that is too early is ended."""
    size = 3 * WIDTH * HEIGHT
    for _ in range(60):
        reader = subprocess.Popen(
            ["gst-launch-1.0", "-q", *PIPELINE.split()], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        killer = subprocess.Popen(["sh", "-c", f"sleep 3; kill -9 {reader.pid} 2> /dev/null"])
        frame = reader.stdout.read(size)
        if len(frame) == size:
            killer.kill()
            began = time.monotonic()
            while len(frame) == size and time.monotonic() - began < seconds:
                yield time.monotonic(), frame
                frame = reader.stdout.read(size)
            reader.kill()
            return
        reader.wait()


def main():
    # It begins later than the program and ends earlier.
    seen = list(frames(0.6 * float(sys.argv[1])))
    times = [at for at, _ in seen]
    print(
        json.dumps(
            {
                "pictures": len(seen),
                "different": sum(a[1] != b[1] for a, b in zip(seen, seen[1:])),
                "secs": times[-1] - times[0] if seen else 0.0,
                "longest_pause_secs": max((b - a for a, b in zip(times, times[1:])), default=0.0),
            }
        )
    )


main()
