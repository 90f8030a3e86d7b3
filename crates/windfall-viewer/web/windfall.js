// Windfall in a canvas. The types are in windfall.d.ts; the viewer itself is Rust, in windfall_viewer_bg.wasm.
import init, { start } from "./windfall_viewer.js";

/** Why there is no picture: the browser has no WebGPU, or gives no adapter. */
export class NoWebGpu extends Error {
  name = "NoWebGpu";
}

async function checkWebGpu() {
  if (!navigator.gpu) {
    const why = globalThis.isSecureContext ? "this browser has no WebGPU" : "WebGPU needs https or localhost";
    throw new NoWebGpu(why);
  }
  if (!(await navigator.gpu.requestAdapter())) throw new NoWebGpu("this browser gives no WebGPU adapter");
}

// The program, with its bytes counted as they come.
async function download(url, progress) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  const all = Number(response.headers.get("content-length")) || 0;
  let done = 0;
  const count = new TransformStream({
    transform(chunk, controller) {
      done += chunk.byteLength;
      progress(done, all);
      controller.enqueue(chunk);
    },
  });
  return new Response(response.body.pipeThrough(count), { headers: { "content-type": "application/wasm" } });
}

// Baked trees of a folder that has an index, by name: growing them here would take seconds.
function bakedTrees(folder) {
  if (!folder) return undefined;
  const base = new URL(folder, document.baseURI);
  const names = fetch(new URL("index.json", base)).then((index) => (index.ok ? index.json() : []));
  return async (name) => {
    if (!(await names).includes(name)) return undefined;
    const tree = await fetch(new URL(`${name}.glb`, base));
    return tree.ok ? new Uint8Array(await tree.arrayBuffer()) : undefined;
  };
}

let loaded;

/** Puts a viewer into a canvas. */
export async function mount(canvas, options = {}) {
  await checkWebGpu();
  const url = options.wasm ?? new URL("windfall_viewer_bg.wasm", import.meta.url);
  loaded ??= download(url, options.progress ?? (() => {})).then((module_or_path) => init({ module_or_path }));
  await loaded;
  const { link = "", panel = false, playing = true, budget = 40 } = options;
  return new Viewer(await start(canvas, link.replace(/^#/, ""), panel, playing, budget, bakedTrees(options.trees)));
}

/** A viewer in a canvas. */
export class Viewer {
  #handle;

  constructor(handle) {
    this.#handle = handle;
  }

  set(change) {
    if (typeof change === "string") return this.#handle.set(change.replace(/^#/, ""));
    const link = new URLSearchParams(this.link);
    for (const [key, value] of Object.entries(change)) {
      link.set(key, typeof value === "string" ? value : JSON.stringify(value));
    }
    this.#handle.set(link.toString().replaceAll("+", "%20"));
  }

  seek(seconds) {
    this.#handle.seek(seconds);
  }

  play(playing = true) {
    this.#handle.play(playing);
  }

  async open(file) {
    this.#handle.open(file.name, new Uint8Array(await file.arrayBuffer()));
  }

  async screenshot() {
    return new Blob([await this.#handle.screenshot()], { type: "image/png" });
  }

  get link() {
    return this.#handle.link();
  }

  get status() {
    return JSON.parse(this.#handle.status());
  }

  dispose() {
    this.#handle.dispose();
  }
}
