// A film that the browser encodes picture by picture (WebCodecs), and the module puts into a file.
import { FilmFrame } from "./chladni_web.js";

/** What the browser may encode pictures and sound as, the best known first. */
const PICTURES = ["avc1.42002a", "vp09.00.41.08"];
const SOUNDS = ["mp4a.40.2", "opus"];
/** Bits for each pixel of a picture, and for each second of sound. */
const [PIXEL_BITS, SOUND_BITS] = [0.2, 192_000];
/** Seconds between pictures that need none before them. */
const KEY_SECS = 2;
/** Pictures that may wait to be encoded. */
const WAITING = 4;
/** How often an encoder is looked at. */
const TIMER_MS = 5;
/** Units of a second of Opus, whatever it was made of. */
const OPUS_RATE = 48_000;
/** What color spaces are called in films (ISO/IEC 23091-2). */
const COLORS = {
  primaries: { bt709: 1, bt470bg: 5, smpte170m: 6 },
  transfer: { bt709: 1, smpte170m: 6, "iec61966-2-1": 13 },
  matrix: { rgb: 0, bt709: 1, bt470bg: 5, smpte170m: 6 },
};

/** Whether this browser encodes pictures at all; it does so for pages over https, or on this machine. */
export const encodes = () => !!window.VideoEncoder;

async function first(kind, configs) {
  for (const config of configs) {
    if ((await kind.isConfigSupported(config).catch(() => undefined))?.supported) return config;
  }
  return undefined;
}

export class EncodedFilm {
  /** A film of `width` × `height` pixels, of so many pictures a second, with sound of `soundRate`, if any. It is silent where
   * the browser encodes no sound, or none that a file can hold, as `isSilent` says in the end. */
  static async open(width, height, rate, soundRate) {
    const bitrate = Math.round(PIXEL_BITS * width * height * rate);
    const pictures = await first(VideoEncoder, PICTURES.map((codec) => (
      { codec, width, height, framerate: rate, bitrate, latencyMode: "quality", ...(codec.startsWith("avc1") && { avc: { format: "avc" } }) })));
    if (!pictures) throw new Error(`This browser encodes no films of ${width} × ${height} pixels.`);
    const sounds = soundRate && window.AudioEncoder && await first(AudioEncoder, SOUNDS.map((codec) => (
      { codec, sampleRate: soundRate, numberOfChannels: 2, bitrate: SOUND_BITS })));
    return new EncodedFilm(pictures, sounds || undefined);
  }

  constructor(pictures, sounds) {
    Object.assign(this, { config: pictures, sounds, pieces: [], count: 0 });
    const error = (failed) => { this.failed ??= failed; };
    const taken = (isSound) => (chunk, metadata) => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      this.pieces.push({ data, isSound, micros: chunk.duration, isKey: chunk.type === "key" });
      if (metadata?.decoderConfig) this[isSound ? "soundAs" : "picturesAs"] ??= metadata.decoderConfig;
    };
    this.painter = new VideoEncoder({ output: taken(false), error });
    this.painter.configure(pictures);
    if (!sounds) return;
    this.singer = new AudioEncoder({ output: taken(true), error });
    this.singer.configure(sounds);
  }

  /** Takes the next picture; `await` it before the one after. */
  async picture(canvas) {
    const { framerate: rate } = this.config;
    const micros = (n) => Math.round((1e6 * n) / rate);
    const frame = new VideoFrame(canvas, { timestamp: micros(this.count), duration: micros(this.count + 1) - micros(this.count), alpha: "discard" });
    const keyFrame = this.count % Math.round(KEY_SECS * rate) === 0;
    this.count++;
    try { this.painter.encode(frame, { keyFrame }); } finally { frame.close(); }
    while (this.painter.encodeQueueSize > WAITING && !this.failed) await this.oneLess();
    if (this.failed) throw this.failed;
  }

  /** Until a picture less waits, as far as the browser says so. Timers, which rest in a page that is not seen, are for those
   * that do not, and for an encoder that fails. */
  oneLess() {
    return new Promise((done) => {
      this.painter.ondequeue = done;
      setTimeout(done, TIMER_MS);
    });
  }

  /** Takes sound: both channels from one sample to another. */
  sound(left, right, from, to) {
    if (!this.singer || to <= from) return;
    const count = to - from;
    const data = new Float32Array(2 * count);
    data.set(left.subarray(from, to));
    data.set(right.subarray(from, to), count);
    const { sampleRate } = this.sounds;
    this.soundFrom ??= from;
    const timestamp = Math.round((1e6 * (from - this.soundFrom)) / sampleRate);
    const heard = new AudioData({ format: "f32-planar", sampleRate, numberOfFrames: count, numberOfChannels: 2, timestamp, data });
    this.singer.encode(heard);
    heard.close();
  }

  /** The whole film, as a file. */
  async end() {
    await Promise.all([this.painter.flush(), this.singer?.flush()]);
    if (this.failed) throw this.failed;
    return this.file();
  }

  /** Whether it has no sound that a file can hold; known once it has ended. */
  get isSilent() { return !this.soundAs; }

  /** Whether a picture is encoded by now. */
  get hasPictures() { return !!this.picturesAs; }

  /** What is encoded by now, as a file. */
  file() {
    const { width, height, framerate, codec } = this.config;
    const { description, colorSpace = {} } = this.picturesAs;
    const colors = Object.entries(COLORS).map(([name, known]) => known[colorSpace[name]] ?? 1);
    const frame = new FilmFrame(codec, bytesOf(description), width, height, framerate, Uint8Array.from([...colors, colorSpace.fullRange ? 1 : 0]));
    let soundRate = 1;
    if (this.soundAs) {
      soundRate = this.sounds.codec === "opus" ? OPUS_RATE : this.soundAs.sampleRate;
      // Pictures without sound are better than none.
      try {
        frame.with_sound(this.sounds.codec, bytesOf(this.soundAs.description), soundRate);
      } catch { this.soundAs = undefined; }
    }
    const pieces = this.pieces.filter(({ isSound }) => !isSound || this.soundAs);
    for (const { data, isSound, micros, isKey } of pieces) {
      frame.add(isSound, data.length, isSound ? Math.round((micros * soundRate) / 1e6) : 1, isKey);
    }
    const film = new Blob([frame.head(), ...pieces.map(({ data }) => data)], { type: "video/mp4" });
    frame.free();
    return film;
  }

  /** Nothing more is wanted of it. */
  close() {
    for (const encoder of [this.painter, this.singer]) if (encoder && encoder.state !== "closed") encoder.close();
    this.pieces.length = 0;
  }
}

const bytesOf = (source) => (!source ? new Uint8Array() : source instanceof ArrayBuffer ? new Uint8Array(source) : new Uint8Array(source.buffer, source.byteOffset, source.byteLength));
