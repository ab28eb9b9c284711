"""A small S3 server for tests: objects of a folder, read by HEAD, GET with ranges, and lists; keys are asked for."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from email.utils import formatdate
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape

KEY = "AKIATEST"


@contextmanager
def served(root: Path) -> Iterator[tuple[str, list[str]]]:
    """Serve the folders of a folder as buckets; yield the address, and what is asked, as it comes."""
    asked: list[str] = []

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def log_message(self, *given: object) -> None:
            pass

        def answer(self, status: int, body: bytes = b"", **heads: str) -> None:
            self.send_response(status)
            for name, value in {"Content-Length": str(len(body)), "Content-Type": "application/xml", **heads}.items():
                self.send_header(name.replace("_", "-"), value)
            self.end_headers()
            if self.command != "HEAD":
                self.wfile.write(body)

        def do_HEAD(self) -> None:
            self.do_GET()

        def do_GET(self) -> None:
            asked.append(f"{self.command} {self.path}")
            if f"Credential={KEY}/" not in self.headers.get("Authorization", ""):
                return self.answer(403, b"<Error><Code>AccessDenied</Code></Error>")
            url = urlsplit(self.path)
            words, path = parse_qs(url.query, keep_blank_values=True), root / unquote(url.path).lstrip("/")
            if "list-type" in words:
                return self.listed(path, words.get("prefix", [""])[0])
            if not path.is_file():
                return self.answer(404, b"<Error><Code>NoSuchKey</Code></Error>")
            data, about = path.read_bytes(), path.stat()
            heads = {"Last_Modified": formatdate(about.st_mtime, usegmt=True), "ETag": f'"{about.st_mtime_ns}"'}
            said = self.headers.get("Range", "")
            if said:
                first, _, last = said.removeprefix("bytes=").partition("-")
                start, stop = int(first), min(int(last) + 1 if last else len(data), len(data))
                heads["Content_Range"] = f"bytes {start}-{stop - 1}/{len(data)}"
                return self.answer(206, data[start:stop], **heads)
            if self.command == "HEAD":
                self.send_response(200)
                for name, value in {**heads, "Content-Length": str(len(data))}.items():
                    self.send_header(name.replace("_", "-"), value)
                return self.end_headers()
            return self.answer(200, data, **heads)

        def listed(self, bucket: Path, prefix: str) -> None:
            files = [one for one in sorted(bucket.rglob("*")) if one.is_file()]
            keys = [one.relative_to(bucket).as_posix() for one in files]
            parts = [f"<Contents><Key>{escape(key)}</Key><Size>{(bucket / key).stat().st_size}</Size></Contents>"
                     for key in keys if key.startswith(prefix)]  # fmt: skip
            text = f"<ListBucketResult><KeyCount>{len(parts)}</KeyCount>{''.join(parts)}</ListBucketResult>"
            self.answer(200, text.encode())

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}", asked
    finally:
        server.shutdown()
        server.server_close()
