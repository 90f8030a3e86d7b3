"""Drives the viewer's page in Chromium over its DevTools protocol, as a person would: scripts/check-web runs it.

    check_web.py CHROMIUM PROGRAM FOLDER OUT

PROGRAM is `windfall`, which serves FOLDER (what scripts/web made); pictures and what went wrong go to OUT. The
protocol runs over two pipes, so that nothing but Python's own library is needed.
"""

import base64
import json
import os
import re
import select
import subprocess
import sys
import tempfile
import time
import zlib

SIZE = (640, 400)
PATIENCE = 90.0
REFERENCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../crates/windfall-viewer/tests/references/page.png")
# Chromium's software adapter is its own, with other rounding than the one that drew the reference on another version.
MEAN, WORST = 6.0, 40.0


class Failure(Exception):
    pass


class Browser:
    """One tab of a Chromium of our own."""

    def __init__(self, program, folder, *flags):
        (to_read, to_write), (from_read, from_write) = os.pipe(), os.pipe()

        def pipes():
            # The browser reads from 3 and writes to 4; neither may be overwritten before it is copied.
            there, back = os.dup(to_read), os.dup(from_write)
            high = [os.dup2(there, 30), os.dup2(back, 31)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self.process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--no-first-run", "--remote-debugging-pipe",
             "--disable-background-networking", "--disable-component-update", f"--user-data-dir={folder}",
             f"--window-size={SIZE[0]},{SIZE[1]}", "--hide-scrollbars", "--force-color-profile=srgb",
             "--force-device-scale-factor=1", *flags, "about:blank"],
            preexec_fn=pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(from_write)
        self.to, self.back = to_write, from_read
        self.buffer, self.last, self.events = b"", 0, []
        self.session = None
        targets = self.send("Target.getTargets")["targetInfos"]
        page = next(t["targetId"] for t in targets if t["type"] == "page")
        self.session = self.send("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        for part in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{part}.enable")
        self.send("Emulation.setDeviceMetricsOverride", width=SIZE[0], height=SIZE[1], deviceScaleFactor=1, mobile=False)

    def receive(self, seconds):
        end = time.monotonic() + seconds
        while b"\0" not in self.buffer:
            left = end - time.monotonic()
            if left <= 0 or not select.select([self.back], [], [], left)[0]:
                return None
            got = os.read(self.back, 1 << 20)
            if not got:
                raise Failure("the browser has gone")
            self.buffer += got
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def send(self, method, **params):
        self.last += 1
        message = {"id": self.last, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.to, data):]
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            answer = self.receive(end - time.monotonic())
            if answer is None:
                break
            if answer.get("id") == self.last:
                if "error" in answer:
                    raise Failure(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)
        raise Failure(f"{method}: no answer")

    def run(self, script):
        result = self.send("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise Failure(f"{script}: {details.get('exception', {}).get('description', details['text'])}")
        return result["result"].get("value")

    def wait(self, what, script, patience=PATIENCE):
        end = time.monotonic() + patience
        while time.monotonic() < end:
            value = self.run(script)
            if value:
                return value
            time.sleep(0.1)
        status = self.run("globalThis.windfall ? JSON.stringify(windfall.status) : document.body.innerText")
        raise Failure(f"{what}: waited {patience:.0f} s for it; {status}; {self.errors()}")

    def open(self, url):
        self.send("Page.navigate", url="about:blank")
        self.send("Page.navigate", url=url)

    def look(self):
        """What the window shows, as bytes of a PNG."""
        return base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])

    def errors(self):
        """What went wrong, in the words of the console."""
        found = []
        for event in self.events:
            params = event.get("params", {})
            if event.get("method") == "Runtime.exceptionThrown":
                details = params["exceptionDetails"]
                found.append(details.get("exception", {}).get("description") or details["text"])
            if event.get("method") == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
                found.append(" ".join(str(a.get("value", a.get("description"))) for a in params["args"]))
            if event.get("method") == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
                found.append(f"{params['entry']['text']} {params['entry'].get('url', '')}")
        return found

    def addresses(self):
        """Every address that was asked for."""
        asked = [e["params"]["request"]["url"] for e in self.events if e.get("method") == "Network.requestWillBeSent"]
        return [url for url in asked if not url.startswith(("data:", "blob:", "about:"))]

    def close(self):
        try:
            self.session = None
            self.send("Browser.close")
            self.process.wait(10)
        except (Failure, OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()


def decode(png):
    """Width, height, and rows of RGB of an eight-bit PNG without interlace."""
    at, data, head = 8, b"", None
    while at < len(png):
        length, kind = int.from_bytes(png[at:at + 4], "big"), png[at + 4:at + 8]
        body = png[at + 8:at + 8 + length]
        if kind == b"IHDR":
            head = body
        if kind == b"IDAT":
            data += body
        at += 12 + length
    width, height, channels = int.from_bytes(head[:4], "big"), int.from_bytes(head[4:8], "big"), {2: 3, 6: 4}[head[9]]
    raw, stride = zlib.decompress(data), width * channels
    before, rows = bytearray(stride), []
    for y in range(height):
        start = y * (stride + 1)
        kind, line = raw[start], bytearray(raw[start + 1:start + 1 + stride])
        for i in range(stride):
            left = line[i - channels] if i >= channels else 0
            corner = before[i - channels] if i >= channels else 0
            up = before[i]
            if kind == 1:
                line[i] = line[i] + left & 255
            elif kind == 2:
                line[i] = line[i] + up & 255
            elif kind == 3:
                line[i] = line[i] + (left + up) // 2 & 255
            elif kind == 4:
                guess = left + up - corner
                nearest = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))
                line[i] = line[i] + nearest[2] & 255
        rows.append(bytes(v for x in range(width) for v in line[x * channels:x * channels + 3]))
        before = line
    return width, height, rows


def difference(a, b, block=8):
    """Mean and largest difference of blocks of two pictures, in steps of 255."""
    (width, height, rows), (width_b, height_b, rows_b) = decode(a), decode(b)
    if (width, height) != (width_b, height_b):
        return 255.0, 255.0
    differences = []
    for top in range(0, height - block + 1, block):
        for left in range(0, width - block + 1, block):
            for c in range(3):
                def mean(of):
                    return sum(sum(of[y][3 * left + c:3 * (left + block):3]) for y in range(top, top + block)) / block**2
                differences.append(abs(mean(rows) - mean(rows_b)))
    return sum(differences) / len(differences), max(differences)


def drop(browser, name, data):
    """A file that is dropped onto the canvas."""
    browser.run(f"""(() => {{
        const bytes = Uint8Array.from(atob({json.dumps(base64.b64encode(data).decode())}), (c) => c.charCodeAt(0));
        const transfer = new DataTransfer();
        transfer.items.add(new File([bytes], {json.dumps(name)}));
        const canvas = document.querySelector("canvas");
        for (const type of ["dragenter", "dragover", "drop"])
            canvas.dispatchEvent(new DragEvent(type, {{ dataTransfer: transfer, bubbles: true, cancelable: true }}));
    }})()""")


READY = "globalThis.windfall && !windfall.status.loading && windfall.status.pictures > 0"
PICTURE = """(async () => {
    const bytes = new Uint8Array(await (await windfall.screenshot()).arrayBuffer());
    let text = "";
    for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
    return btoa(text);
})()"""


def main():
    chromium, windfall, folder, out = sys.argv[1:5]
    os.makedirs(out, exist_ok=True)

    def keep(name, data):
        with open(os.path.join(out, name), "wb") as file:
            file.write(data)

    def check(true, text):
        if not true:
            raise Failure(text)

    server = subprocess.Popen([windfall, "serve", folder, "--port", "0"], stderr=subprocess.PIPE, text=True)
    address = re.search(r"http://\S+", server.stderr.readline()).group()
    try:
        with tempfile.TemporaryDirectory() as scratch:
            drive(chromium, windfall, address, scratch, keep, check)
    finally:
        server.kill()


def drive(chromium, windfall, address, scratch, keep, check):
    software = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-unsafe-webgpu",
                "--ignore-gpu-blocklist", "--enable-gpu", "--enable-features=Vulkan", "--use-vulkan=swiftshader"]
    browser = Browser(chromium, os.path.join(scratch, "a"), *software)
    try:
        run(browser, address, scratch, windfall, keep, check)
    finally:
        keep("last.png", browser.look())
        browser.close()
    # A browser without WebGPU.
    browser = Browser(chromium, os.path.join(scratch, "b"), "--disable-gpu", "--disable-features=WebGPU")
    try:
        browser.open(address)
        says = browser.wait("a sentence",
                            "document.getElementById('says')?.textContent.includes('WebGPU') && says.textContent")
        keep("without-webgpu.png", browser.look())
        print(f"without WebGPU: {says}")
    finally:
        browser.close()


def run(browser, address, scratch, windfall, keep, check):
    def picture():
        return base64.b64decode(browser.run(PICTURE))

    shown = "#scene=lone-oak&time=0&wind.speed=0"
    start = time.monotonic()
    browser.open(address + shown)
    browser.wait("the first picture", READY)
    print(f"first picture: {time.monotonic() - start:.1f} s after the page was asked for")
    browser.run("windfall.play(false), windfall.seek(0)")
    first = picture()
    keep("page.png", first)
    keep("window.png", browser.look())
    if os.environ.get("WINDFALL_BLESS") == "1":
        with open(REFERENCE, "wb") as file:
            file.write(first)
    with open(REFERENCE, "rb") as file:
        mean, worst = difference(first, file.read())
    print(f"page.png differs from its reference by {mean:.2f} on average, {worst:.1f} at most")
    check(mean <= MEAN and worst <= WORST, f"the forest is not the reference: {mean:.2f}, {worst:.1f}; see page.png")

    browser.run("windfall.seek(150)")
    later = picture()
    keep("later.png", later)
    moved, _ = difference(first, later)
    check(moved > 1.0, f"scrubbing changes nothing: {moved:.3f}")
    browser.run("windfall.seek(0)")
    again, worst = difference(first, picture())
    check(worst < 1.0, f"time that runs back shows something else: {again:.3f}, {worst:.1f}")

    # The address is a link: opened anew it is the same picture.
    browser.run("windfall.set({season: 0.9}), windfall.seek(40)")
    browser.wait("loaded", READY)
    linked = picture()
    browser.wait("an address with the season", "location.hash.includes('season=0.9') && location.hash.includes('time=40')")
    link = browser.run("location.href")
    browser.open(link)
    browser.wait("the picture of a link", READY)
    browser.run("windfall.play(false), windfall.seek(40)")
    mean, worst = difference(linked, picture())
    check(worst < 4.0, f"{link} shows something else: {mean:.3f}, {worst:.1f}")
    check(difference(linked, first)[0] > 1.0, "season 0.9 looks like the first picture")

    # Mouse, and fingers.
    def camera():
        return browser.run("new URLSearchParams(windfall.link).get('camera')")

    def mouse(kind, x, y, **more):
        browser.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    stood = camera()
    mouse("mousePressed", 300, 200, button="left", clickCount=1)
    for x in (320, 340, 360):
        mouse("mouseMoved", x, 200, button="left", buttons=1)
        time.sleep(0.1)
    mouse("mouseReleased", 360, 200, button="left", clickCount=1)
    browser.wait("a turned camera", f"new URLSearchParams(windfall.link).get('camera') != {json.dumps(stood)}", 20)
    stood = camera()
    for kind, apart in (("touchStart", 40), ("touchMove", 60), ("touchMove", 90), ("touchMove", 120), ("touchEnd", None)):
        points = [] if apart is None else [{"x": 300 - apart, "y": 200, "id": 1}, {"x": 300 + apart, "y": 200, "id": 2}]
        browser.send("Input.dispatchTouchEvent", type=kind, touchPoints=points)
        time.sleep(0.1)
    browser.wait("a nearer camera", f"new URLSearchParams(windfall.link).get('camera') != {json.dumps(stood)}", 20)

    # Files.
    tree = os.path.join(scratch, "aspen.glb")
    subprocess.run([windfall, "bake", "aspen", "--out", tree], check=True, stdout=subprocess.DEVNULL)
    before = picture()
    drop(browser, "bad.glb", b"glTF, or so it says")
    error = browser.wait("an error", "windfall.status.errors.find((e) => e.includes('bad.glb'))")
    print(f"a bad file: {error}")
    browser.wait("loaded", READY)
    check(difference(before, picture())[1] < 4.0, "a bad file changes the picture")
    loads = browser.run("windfall.status.loads")
    with open(tree, "rb") as file:
        drop(browser, "aspen.glb", file.read())
    browser.wait("the tree", f"windfall.status.loads > {loads}")
    browser.wait("loaded", READY)
    dropped = picture()
    keep("dropped.png", dropped)
    keep("window-dropped.png", browser.look())
    check(difference(before, dropped)[0] > 2.0, "a dropped tree does not appear")
    outside = [url for url in browser.addresses() if not url.startswith(address)]
    check(not outside, f"the page asked elsewhere: {outside}")

    # The interface for pages, in 30 lines.
    browser.open(address + "example.html")
    browser.wait("the example", "document.querySelector('canvas') && globalThis.forest?.status?.pictures > 0 && !forest.status.loading")
    keep("example.png", browser.look())
    browser.run("forest.dispose()")
    check(not browser.errors(), "in the console: " + "; ".join(browser.errors()))


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        print(f"failed: {failure}", file=sys.stderr)
        sys.exit(1)
