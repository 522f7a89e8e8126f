// One more thread of a worker, whose memory it shares: it does what the pool there gives it, until the page ends it.
import init, { join_pool } from "./chladni_threads.js";

onmessage = async ({ data }) => {
  try {
    await init(data);
    join_pool();
  } catch (error) {
    // The worker waits for this thread, so that the page has to end it.
    postMessage({ kind: "broken", text: error.message ?? String(error) });
  }
};
