// What a microphone hears, from the thread of the sound to the page: blocks of the left channel and then the right.
const FRAMES = 512;

class Capture extends AudioWorkletProcessor {
  constructor() {
    super();
    this.block = new Float32Array(2 * FRAMES);
    this.filled = 0;
  }

  process([[left, right = left] = []]) {
    if (!left) return true;
    this.block.set(left, this.filled);
    this.block.set(right, FRAMES + this.filled);
    this.filled += left.length;
    if (this.filled >= FRAMES) {
      this.port.postMessage(this.block);
      this.filled = 0;
    }
    return true;
  }
}

registerProcessor("capture", Capture);
