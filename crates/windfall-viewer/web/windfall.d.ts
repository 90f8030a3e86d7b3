/** Why there is no picture: the browser has no WebGPU, or gives no adapter. */
export class NoWebGpu extends Error {}

export interface Options {
  /** The hash of a link: `scene=autumn&time=12.5&season=0.8`. The default scene if empty. */
  link?: string;
  /** Whether the panel is shown; by default not. */
  panel?: boolean;
  /** Whether time runs; by default it does. */
  playing?: boolean;
  /** Time that a picture is to take at most while things move, milliseconds: by default 40; 0 gives up nothing. */
  budget?: number;
  /** Where `windfall_viewer_bg.wasm` is; by default beside `windfall.js`. */
  wasm?: string | URL;
  /** A folder with baked trees of named scenes, `trees/`; without it they are grown here, which takes seconds. */
  trees?: string | URL;
  /** Told of bytes while the program is loaded; `all` is 0 where the server does not say it. */
  progress?: (done: number, all: number) => void;
}

export interface Status {
  /** Whether trees are being loaded. */
  loading: boolean;
  /** Pictures drawn. */
  pictures: number;
  /** Times that trees were loaded. */
  loads: number;
  /** The moment that is shown, seconds. */
  time: number;
  /** Errors that were shown. */
  errors: string[];
  /** Notes that were shown. */
  notes: string[];
}

/** Puts a viewer into a canvas. Rejects with {@link NoWebGpu} where there is no WebGPU. */
export function mount(canvas: HTMLCanvasElement, options?: Options): Promise<Viewer>;

/** A viewer in a canvas. */
export class Viewer {
  /**
   * Shows what a link says, or changes single values: `set({ season: 0.8, "wind.speed": 4 })`. Keys and values are those
   * of scene files, and `scene`, `throw`, `view`, `effects` and `camera` as in links.
   */
  set(change: string | Record<string, unknown>): void;
  /** Goes to a moment, seconds, and stands there. */
  seek(seconds: number): void;
  /** Lets time run or stand. */
  play(playing?: boolean): void;
  /** Opens a tree, fall path, scene or picture of the sky. It does not leave the browser. */
  open(file: File): Promise<void>;
  /** The next picture, without the panel, as PNG. */
  screenshot(): Promise<Blob>;
  /** The hash of a link to what is shown. */
  readonly link: string;
  /** What goes on. */
  readonly status: Status;
  /** Takes the viewer out of its canvas. */
  dispose(): void;
}
