// What plays, and where in it we are: the clock of what is heard. Before a person has asked for sound, which browsers
// demand, the song runs on silently, so that the picture moves at once.

/** How long a sound device may take to begin. Firefox waits for one for ever. */
const PATIENCE_SECS = 2;

/** Whether a context runs, after as long as a device may take. `resumed` is its promise; a browser that holds the sound back
 * rejects it. */
export async function runs(context, resumed = context.resume()) {
  await Promise.race([resumed.catch(() => {}), new Promise((done) => setTimeout(done, 1000 * PATIENCE_SECS))]);
  return context.state === "running";
}

/** Says what the sound is for, where a browser asks: on an iPhone, that of a "playback" is heard with its ring switch on
 * silent, too. */
export function soundsAs(type) {
  if (navigator.audioSession) navigator.audioSession.type = type;
}

export class Sound {
  constructor() {
    this.number = -1;
    this.duration = 0;
    this.silentSince = performance.now() / 1000;
    this.from = 0;
    this.playing = true;
    this.volume = 1;
    /** How often it was paused. */
    this.pauses = 0;
    /** It was heard to its end, and nothing was done since. */
    this.hasEnded = false;
  }

  /** A song from its beginning. One that does not repeat calls `onend` at its end, where it is heard. */
  load({ rate_hz: rate, left, right }, repeats) {
    this.stopSource();
    this.samples = { rate, left, right };
    this.buffer = undefined;
    this.repeats = repeats;
    this.duration = left.length / rate;
    this.seek(0);
  }

  get isHeard() { return this.context?.state === "running" && !!this.source; }

  /** Seconds into the song; one that repeats, or is not heard, begins anew when it ends. */
  position() {
    if (!this.duration) return 0;
    let gone = 0;
    if (this.source) gone = this.heardNow() - this.began;
    else if (this.playing) gone = performance.now() / 1000 - this.silentSince;
    const at = this.from + Math.max(0, gone);
    // One that was interrupted stays at its end, as one that is heard.
    const ends = !this.repeats && (this.source || this.isInterrupted);
    return ends ? Math.min(at, this.duration) : at % this.duration;
  }

  /** The context's time of what leaves the loudspeaker now. */
  heardNow() {
    const { contextTime, performanceTime } = this.context.getOutputTimestamp?.() ?? {};
    if (!performanceTime) return this.context.currentTime - this.lateSecs();
    const since = (performance.now() - performanceTime) / 1000;
    return Math.min(contextTime + since, this.context.currentTime);
  }

  /** How much later than the context's time the loudspeaker sounds. */
  lateSecs() { return this.context.outputLatency || this.context.baseLatency || 0; }

  /** Aloud from here on; call it from a click. False where no sound device begins: the song runs on silently then, and
   * aloud as soon as one does. A pause meanwhile has the last word. */
  async play() {
    let at = this.position();
    const { pauses } = this;
    soundsAs("playback");
    const resumed = this.ensureContext().resume();
    const isRunning = await runs(this.context, resumed);
    if (pauses !== this.pauses) return true;
    if (!isRunning) {
      if (!this.playing) this.seek(at);
      this.playing = true;
      const goOn = () => { if (pauses === this.pauses && this.playing && !this.source) this.play(); };
      resumed.then(goOn, () => {});
      return false;
    }
    if (this.playing && !this.source) at = this.position();
    if (!this.buffer && this.samples) {
      const { rate, left, right } = this.samples;
      this.buffer = this.context.createBuffer(2, left.length, rate);
      this.buffer.copyToChannel(left, 0);
      this.buffer.copyToChannel(right, 1);
    }
    this.playing = true;
    this.startSource(at);
    return true;
  }

  pause() {
    this.pauses++;
    this.from = this.position();
    this.isInterrupted = false;
    this.stopSource();
    this.playing = false;
  }

  seek(secs) {
    const aloud = !!this.source;
    this.from = secs;
    this.silentSince = performance.now() / 1000;
    if (aloud) this.startSource(secs);
  }

  startSource(at) {
    this.stopSource();
    this.isInterrupted = false;
    if (!this.buffer) return;
    this.source = this.context.createBufferSource();
    this.source.buffer = this.buffer;
    this.source.loop = this.repeats;
    this.source.onended = () => { this.hasEnded = true; this.onend?.(); };
    this.source.connect(this.outlet());
    this.began = this.context.currentTime;
    this.from = at;
    this.source.start(this.began, at);
  }

  /** The context, made where it is asked for first. A change of its state calls `onchange`. */
  ensureContext() {
    if (this.context) return this.context;
    const context = this.context = new AudioContext();
    context.onstatechange = () => {
      if (context.state === "running") this.goOnAloud();
      else if (this.source && context.state !== "closed") this.goOnSilently();
      this.onchange?.();
    };
    return context;
  }

  /** The system has interrupted the sound, as by a call or for another device. */
  goOnSilently() {
    const at = this.position();
    this.stopSource();
    this.seek(at);
    this.isInterrupted = true;
    this.context.resume().catch(() => {});
  }

  goOnAloud() {
    if (this.isInterrupted && this.playing && !this.source) this.play();
  }

  /** What is heard comes through here, so that films hear it, too. */
  outlet() {
    if (this.out) return this.out;
    this.out = this.ensureContext().createGain();
    this.loudness = this.context.createGain();
    this.loudness.gain.value = this.volume;
    this.out.connect(this.loudness).connect(this.context.destination);
    return this.out;
  }

  /** How loud it is, from 0 to 1; films and dances are as they are. */
  setVolume(volume) {
    this.volume = volume;
    if (this.loudness) this.loudness.gain.value = volume;
  }

  /** The song that plays begins anew at its end, or no more. */
  setRepeats(on) {
    if (this.repeats === on) return;
    // Its place among all of its rounds is one in this round.
    const at = this.position();
    this.repeats = on;
    this.seek(at);
  }

  /** The sound of the room, for a film: its tracks; `follow(stream)`, after which a microphone's stream is heard, too, or
   * none; `keepLate()`, to be called now and then, as another device may be late otherwise; and `end()` when they are no
   * longer wanted. */
  overheard() {
    const ear = this.outlet().context.createMediaStreamDestination();
    // Pictures are of what leaves the loudspeaker: a film has the song as late.
    const late = this.context.createDelay(1);
    const keepLate = () => {
      if (Math.abs(late.delayTime.value - this.lateSecs()) > 0.01) late.delayTime.value = this.lateSecs();
    };
    keepLate();
    // Where no song was heard yet it does not run.
    this.context.resume().catch(() => {});
    this.out.connect(late).connect(ear);
    let heard;
    let source;
    const follow = (stream) => {
      if (stream === heard) return;
      source?.disconnect();
      source = stream && this.context.createMediaStreamSource(stream);
      source?.connect(ear);
      heard = stream;
    };
    const tracks = ear.stream.getAudioTracks();
    const end = () => {
      follow(undefined);
      this.out.disconnect(late);
      for (const track of tracks) track.stop();
    };
    return { tracks, follow, keepLate, end };
  }

  stopSource() {
    this.hasEnded = false;
    if (this.source) this.source.onended = null;
    this.source?.stop();
    this.source?.disconnect();
    this.source = undefined;
    this.silentSince = performance.now() / 1000;
  }
}
