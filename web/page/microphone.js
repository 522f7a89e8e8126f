// A microphone, and what a browser says where it lends none.
import { runs, soundsAs } from "./sound.js";

const REFUSED = {
  NotAllowedError: "The microphone was refused: allow it for this page, then press Listen again.",
  NotFoundError: "No microphone was found.",
  NotReadableError: "The microphone cannot be read: perhaps another program has it.",
  OverconstrainedError: "That microphone is gone.",
};
/** The sound as it is: nothing of it is an echo or noise here. */
const AS_IT_IS = { echoCancellation: false, noiseSuppression: false, autoGainControl: false };
/** What is left of the loudest sample in the next block, a hundredth of a second later. */
const FALL = 0.97;

/** Microphones that are open, or about to be. */
let count = 0;

/** One more is open, or one less. */
function counts(by) {
  count += by;
  soundsAs(count ? "play-and-record" : "playback");
}

export class Microphone {
  /** Listens to the microphone of an id, or to the browser's own; `take(left, right)` gets what it hears, `lost()` is called
   * where it is unplugged. */
  static async open(id, take, lost) {
    if (!navigator.mediaDevices) throw new Error("A browser lends its microphone to pages over https or on this machine only.");
    const audio = { ...AS_IT_IS, ...(id && { deviceId: { exact: id } }) };
    counts(1);
    let stream;
    try { stream = await navigator.mediaDevices.getUserMedia({ audio }); } catch (error) {
      counts(-1);
      throw new Error(REFUSED[error.name] ?? error.message);
    }
    const context = new AudioContext();
    try {
      if (!await runs(context)) throw new Error("No sound device answers, without which a microphone cannot be heard.");
      await context.audioWorklet.addModule("capture.js");
    } catch (error) {
      for (const track of stream.getTracks()) track.stop();
      // One that never began may never end.
      context.close().catch(() => {});
      counts(-1);
      throw error;
    }
    return new Microphone(stream, context, take, lost);
  }

  constructor(stream, context, take, lost) {
    Object.assign(this, { stream, context, loudest: 0 });
    const [track] = stream.getAudioTracks();
    track.addEventListener("ended", lost);
    const stereo = { channelCount: 2, channelCountMode: "explicit", channelInterpretation: "speakers" };
    this.capture = new AudioWorkletNode(context, "capture", { numberOfOutputs: 0, ...stereo });
    this.capture.port.onmessage = ({ data }) => {
      this.loudest = data.reduce((most, sample) => Math.max(most, Math.abs(sample)), FALL * this.loudest);
      take(data.subarray(0, data.length / 2), data.subarray(data.length / 2));
    };
    this.source = context.createMediaStreamSource(stream);
    this.source.connect(this.capture);
    // A call on a phone, or another device, may interrupt it.
    context.onstatechange = () => {
      if (!["running", "closed"].includes(context.state)) context.resume().catch(() => {});
    };
  }

  get name() { return this.stream.getAudioTracks()[0].label || "Microphone"; }
  get id() { return this.stream.getAudioTracks()[0].getSettings().deviceId; }
  get rate() { return this.context.sampleRate; }

  close() {
    this.capture.port.onmessage = null;
    for (const track of this.stream.getTracks()) track.stop();
    counts(-1);
    return this.context.close();
  }

  /** All that can be listened to: id and name of each. Names are known once one was allowed. */
  static async all() {
    const devices = await navigator.mediaDevices.enumerateDevices();
    return devices.filter(({ kind }) => kind === "audioinput").map(({ deviceId, label }) => [deviceId, label || "Microphone"]);
  }
}
