"""The page's readers: for each input line, a file name, they print a line of JSON with the result."""

from __future__ import annotations

import base64
import json
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import chromium

from bobrossnet.page.files import page_files
from bobrossnet.page.server import Server

# A hanging worker is replaced, as the page does for the next file.
ASK = """
(request) => new Promise((resolve) => {
  window.worker ??= new Worker("/fuzz/page.js", { type: "module" });
  const end = (answer) => { clearTimeout(timer); resolve(answer); };
  const lost = (says) => {
    worker.terminate();
    window.worker = null;
    end({ loads: false, says, clear: false, seconds: 0 });
  };
  const timer = setTimeout(() => lost("no answer within 30 s"), 30_000);
  worker.onmessage = ({ data }) => end(data);
  worker.onerror = ({ message }) => lost(message);
  worker.postMessage(request);
})
"""


def main() -> None:
    with page_files() as files, Server(files) as server, chromium() as browser:
        server.files["fuzz/page.js"] = Path(__file__).with_name("page.js")
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page = browser.new_page()
        page.goto(server.url + "gallery/index.json")
        print(flush=True)
        for line in sys.stdin:
            file = Path(line.rstrip("\n"))
            content = base64.b64encode(file.read_bytes()).decode()
            answer = page.evaluate(ASK, {"name": file.name, "content": content})
            print(json.dumps(answer), flush=True)
        server.shutdown()


if __name__ == "__main__":
    main()
