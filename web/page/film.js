// Films of the stage as it is seen: a live recording by the browser, with what is heard.
import { copier } from "./picture.js";

/** What the browser may write, the best first. */
const KINDS = ["video/mp4;codecs=avc1.42E01F,mp4a.40.2", "video/webm;codecs=vp8,opus", "video/webm", "video/mp4"];
const BITS_PER_SECOND = 8_000_000;
/** Pixels of the longer side at most: encoders of phones take no more. */
const LONGEST = 1920;
/** Milliseconds in which a recorder that has failed gives its last piece. */
const LAST_PIECE_MS = 1000;

/** The file name's ending for what is recorded. */
const ending = (kind) => (kind.startsWith("video/mp4") ? "mp4" : "webm");

export class LiveFilm {
  /** Begins a film of `width` × `height` pixels or fewer with the sound of `tracks`. */
  constructor(width, height, tracks) {
    const kind = window.MediaRecorder && KINDS.find((each) => MediaRecorder.isTypeSupported(each));
    if (!kind) throw new Error("This browser records no films.");
    const by = Math.min(1, LONGEST / Math.max(width, height));
    // Encoders want even numbers of pixels.
    const [w, h] = [width, height].map((side) => 2 * Math.max(8, Math.round((by * side) / 2)));
    const { canvas, take } = copier(w, h);
    /** Takes a picture as it is seen: a canvas, and the veil over it as a color. */
    this.take = take;
    const stream = canvas.captureStream();
    for (const track of tracks) stream.addTrack(track);
    this.recorder = new MediaRecorder(stream, { mimeType: kind, videoBitsPerSecond: BITS_PER_SECOND });
    this.pieces = [];
    this.recorder.ondataavailable = ({ data }) => { if (data.size) this.pieces.push(data); };
    this.failed = new Promise((_, fail) => { this.recorder.onerror = ({ error }) => fail(error ?? new Error("The film could not be recorded.")); });
    this.failed.catch(() => {});
    this.ended = new Promise((done) => { this.recorder.onstop = done; });
    this.began = performance.now();
    this.recorder.start(1000);
  }

  get secs() { return (performance.now() - this.began) / 1000; }

  /** The whole film, once it has ended. */
  async end() {
    this.recorder.stop();
    await Promise.race([this.ended, this.failed]);
    return this.recorded();
  }

  /** As much of it as there is, where it has failed: the last piece comes after the error. */
  async rest() {
    if (this.recorder.state !== "inactive") this.recorder.stop();
    await Promise.race([this.ended, new Promise((done) => setTimeout(done, LAST_PIECE_MS))]);
    return this.recorded();
  }

  /** As much of it as there is by now. */
  recorded() {
    const { mimeType } = this.recorder;
    return { film: new Blob(this.pieces, { type: mimeType }), ending: ending(mimeType) };
  }
}
