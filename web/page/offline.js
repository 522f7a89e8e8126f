// Keeps what the page has loaded, for when there is no connection. With one, what is there now is shown.
const CACHE = "chladni";

/** Asks for a file, and keeps what comes. */
async function fresh(request) {
  const response = await fetch(request);
  if (response.ok && response.type === "basic") {
    const cache = await caches.open(CACHE);
    await cache.put(request, response.clone());
  }
  return response;
}

const isOurs = (url) => url.startsWith(self.registration.scope);

self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));

self.addEventListener("message", (event) => {
  event.waitUntil(Promise.allSettled(event.data.filter(isOurs).map((url) => fresh(new Request(url)))));
});

self.addEventListener("fetch", (event) => {
  if (event.request.method !== "GET" || !isOurs(event.request.url)) return;
  event.respondWith(fresh(event.request).catch(async (gone) => {
    const kept = await caches.match(event.request, { ignoreVary: true });
    if (kept) return kept;
    throw gone;
  }));
});
