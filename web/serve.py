"""Shows a folder at http://localhost:8080, isolated from all other pages, so that its workers may share memory."""

import functools
import http.server
import sys


# As in offline.js: a worker does not take the policy of the page that starts it.
WORKERS = ("/worker.js", "/thread.js")
POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'"


class Isolated(http.server.SimpleHTTPRequestHandler):
    def end_headers(self):
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        # A request that could not be read has no path.
        if getattr(self, "path", "").endswith(WORKERS):
            self.send_header("Content-Security-Policy", POLICY)
        super().end_headers()


serving = functools.partial(Isolated, directory=sys.argv[1])
with http.server.ThreadingHTTPServer(("localhost", 8080), serving) as server:
    print("http://localhost:8080")
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        pass
