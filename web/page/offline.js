// Keeps what the page has loaded, for when there is no connection. With one, what is there now is shown. And isolates the
// page from all others, as servers that send such headers do: memory that workers share is lent only to pages like that.
const CACHE = "chladni";

/** Asks for a file, and keeps what comes. */
async function fresh(request) {
  const response = await fetch(request);
  if (response.ok && response.type === "basic") {
    const copy = response.clone();
    // What there is no room for, or no cache, is shown, and not kept. What has broken off fails here.
    await caches.open(CACHE).then((cache) => cache.put(keyOf(request), copy)).catch(() => response.clone().arrayBuffer());
  }
  return response;
}

/** What needs the headers: the page itself, and its workers. */
const ISOLATED = ["document", "worker"];

/** The policy of workers, which read files of unknown sources: they do not take that of the page. */
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'";

/** The same, isolated; a worker gets its policy, too. */
function isolated(response, destination) {
  // A redirection, for one, is none of ours.
  if (response.type !== "basic" && response.type !== "default") return response;
  const { body, status, statusText } = response;
  const headers = new Headers(response.headers);
  headers.set("Cross-Origin-Opener-Policy", "same-origin");
  headers.set("Cross-Origin-Embedder-Policy", "require-corp");
  if (destination === "worker") headers.set("Content-Security-Policy", POLICY);
  return new Response(body, { status, statusText, headers });
}

/** Under which address an answer is kept: the page is the same with a query or without, with its file's name or without. */
function keyOf({ url }) {
  const { scope } = self.registration;
  const plain = url.replace(/[?#].*$/, "");
  return [scope, `${scope}index.html`].includes(plain) ? scope : url;
}

const isOurs = (url) => url.startsWith(self.registration.scope);

self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));

self.addEventListener("message", (event) => {
  event.waitUntil(Promise.allSettled(event.data.filter(isOurs).map((url) => fresh(new Request(url)))));
});

self.addEventListener("fetch", (event) => {
  const { method, url, destination } = event.request;
  if (method !== "GET" || !isOurs(url)) return;
  const found = fresh(event.request).catch(async (gone) => {
    const kept = await caches.match(keyOf(event.request), { ignoreVary: true });
    if (kept) return kept;
    throw gone;
  });
  const isIsolated = ISOLATED.includes(destination);
  event.respondWith(isIsolated ? found.then((response) => isolated(response, destination)) : found);
});
