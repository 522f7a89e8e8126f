#!/usr/bin/env python3
"""Songs whose beats are known exactly because they were written as MIDI: renders each to a WAV and
writes its quarter notes beside it.

usage: bench/beats/midi_songs.py FOLDER SONG.mid …
Needs fluidsynth and a General MIDI sound font (Debian: fluidsynth, timgm6mb-soundfont). The 31 songs of
Debian's openttd-openmsx, by several composers, are in /usr/share/games/openttd/baseset/openmsx.
"""
import pathlib
import shutil
import subprocess
import sys

RATE_HZ = 44_100
SECS = 40
SOUND_FONT = "/usr/share/sounds/sf2/TimGM6mb.sf2"
SONGS = pathlib.Path("/usr/share/games/openttd/baseset/openmsx")


def installed():
    """The songs that can be rendered here, in a fixed order; says so where there are none."""
    songs = sorted(SONGS.glob("*.mid"))
    if not songs or not shutil.which("fluidsynth") or not pathlib.Path(SOUND_FONT).exists():
        print("skipped the MIDI songs: openttd-openmsx, fluidsynth or timgm6mb-soundfont is not installed", file=sys.stderr)
        return []
    return songs


def variable_length(data, at):
    value = 0
    while True:
        value, at = value << 7 | data[at] & 0x7F, at + 1
        if data[at - 1] < 0x80:
            return value, at


def events_of(track):
    """(tick, status, data) of every event of a track."""
    at = tick = status = 0
    while at < len(track):
        delta, at = variable_length(track, at)
        tick += delta
        if track[at] >= 0x80:
            status, at = track[at], at + 1
        if status == 0xFF:
            kind = track[at]
            length, at = variable_length(track, at + 1)
            yield tick, status, bytes([kind]) + track[at:at + length]
            at += length
        elif status in (0xF0, 0xF7):
            length, at = variable_length(track, at)
            at += length
        else:
            length = 1 if status & 0xF0 in (0xC0, 0xD0) else 2
            yield tick, status, track[at:at + length]
            at += length


def quarter_notes_secs(midi):
    """Times of the quarter notes from the first note on, until SECS."""
    division = int.from_bytes(midi[12:14], "big")
    if midi[:4] != b"MThd" or division >= 0x8000:
        raise ValueError("no MIDI file that counts in quarter notes")
    at, events = 14, []
    while at < len(midi):
        length = int.from_bytes(midi[at + 4:at + 8], "big")
        if midi[at:at + 4] == b"MTrk":
            events += events_of(midi[at + 8:at + 8 + length])
        at += 8 + length
    tempi = sorted((tick, int.from_bytes(data[1:4], "big")) for tick, status, data in events
                   if status == 0xFF and data[0] == 0x51)
    notes = [tick for tick, status, data in events if status & 0xF0 == 0x90 and data[1] > 0]
    tick = secs = 0.0
    micros, beats = 500_000, []
    beat = -(-min(notes) // division) * division
    while secs < SECS and beat <= max(notes):
        while tempi and tempi[0][0] <= beat:
            at, next_micros = tempi.pop(0)
            secs, tick, micros = secs + (at - tick) * micros / division / 1e6, at, next_micros
        secs, tick = secs + (beat - tick) * micros / division / 1e6, beat
        if secs < SECS:
            beats.append(secs)
        beat += division
    return beats


def render(midi, folder):
    """SECS of the song as WAV and its beats; the WAV's path."""
    wav = folder / f"{midi.stem}.wav"
    raw = folder / f"{midi.stem}.raw.wav"
    subprocess.run(["fluidsynth", "-ni", "-q", "-g", "0.5", "-r", str(RATE_HZ), "-F", raw, SOUND_FONT, midi],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", raw, "-t", str(SECS), wav], check=True)
    raw.unlink()
    beats = quarter_notes_secs(midi.read_bytes())
    wav.with_name(f"{midi.stem}.beats.txt").write_text("".join(f"{beat:.4f}\n" for beat in beats))
    return wav


if __name__ == "__main__":
    for song in sys.argv[2:]:
        print(render(pathlib.Path(song), pathlib.Path(sys.argv[1])))
