"""Shows a folder at http://localhost:8080, isolated from all other pages, so that its workers may share memory."""

import functools
import http.server
import sys


class Isolated(http.server.SimpleHTTPRequestHandler):
    def end_headers(self):
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        super().end_headers()


serving = functools.partial(Isolated, directory=sys.argv[1])
with http.server.ThreadingHTTPServer(("localhost", 8080), serving) as server:
    print("http://localhost:8080")
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        pass
