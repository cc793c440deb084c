// The time line: segments as bands, curves below them, keyframes to drag, and the shown frame.

export const COLOURS = ["#bcd7f5", "#f9d9a8", "#c6e6c3", "#e3cdf2", "#f6c5c0", "#c3e6e6", "#e5e2ae", "#d4d9e2"];
const SVG = "http://www.w3.org/2000/svg";
const BAND = 30, TOP = 52, LOW = 20, SIDE = 12; // pixels: height of a band, curves' top, axis, margin

function make(name, attributes, ...children) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

export class Timeline {
  constructor(svg, { seek, choose, move, add }) {
    Object.assign(this, { svg, seek, choose, move, add, frame: 0 });
    svg.addEventListener("pointerdown", (event) => this.press(event));
    svg.addEventListener("dblclick", (event) => this.add(this.frameAt(event)));
    new ResizeObserver(() => this.draw()).observe(svg);
  }

  show(episode, chosen) {
    Object.assign(this, { episode, chosen });
    this.draw();
  }

  x(frame) {
    return SIDE + (frame / Math.max(this.episode.frames - 1, 1)) * (this.svg.clientWidth - 2 * SIDE);
  }

  frameAt(event) {
    const place = event.clientX - this.svg.getBoundingClientRect().left - SIDE;
    const frame = Math.round((place / (this.svg.clientWidth - 2 * SIDE)) * (this.episode.frames - 1));
    return Math.max(0, Math.min(this.episode.frames - 1, frame));
  }

  setFrame(frame) {
    this.frame = frame;
    if (!this.head || !this.episode) return;
    for (const end of ["x1", "x2"]) this.head.setAttribute(end, this.x(frame));
  }

  curve(values, most, closed) {
    const bottom = this.svg.clientHeight - LOW, height = bottom - TOP - 4;
    const points = values.map((value, frame) => `${this.x(frame).toFixed(1)},${(bottom - (value / most) * height).toFixed(1)}`);
    return closed ? `M${this.x(0)},${bottom}L${points.join("L")}L${this.x(values.length - 1)},${bottom}Z` : `M${points.join("L")}`;
  }

  draw() {
    if (!this.episode || !this.svg.clientWidth) return;
    const { episode, svg } = this, bottom = svg.clientHeight - LOW, most = Math.max(0.05, ...episode.speed);
    const parts = [];
    const seconds = (episode.frames - 1) / episode.fps;
    const step = [0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300].find((one) => seconds / one <= 14) ?? 600;
    for (let second = 0; second <= seconds; second += step) {
      const x = this.x(second * episode.fps);
      parts.push(make("line", { class: "grid", x1: x, x2: x, y1: TOP, y2: bottom }));
      parts.push(make("text", { x, y: svg.clientHeight - 6, "text-anchor": x < 20 ? "start" : "middle" }, `${second} s`));
    }
    parts.push(make("path", { class: "speed", d: this.curve(episode.speed, most, true) }));
    parts.push(make("path", { class: "opening", d: this.curve(episode.opening, 1, false) }));
    document.getElementById("most").textContent = `up to ${most.toFixed(2)} m/s`;
    let begin = 0;
    episode.keyframes.forEach((key, at) => {
      const left = this.x(begin), width = Math.max(0, this.x(key.frame) - left), chosen = at === this.chosen;
      const colour = COLOURS[at % COLOURS.length];
      const band = { class: chosen ? "band chosen" : "band", x: left, y: 4, width, height: BAND, rx: 4, fill: colour };
      const words = key.text || "no instruction", fits = Math.floor((width - 10) / 6.2);
      const title = make("title", {}, `${at + 1}: ${words}`);
      parts.push(make("rect", band, title));
      const said = words.length <= fits ? words : fits > 4 ? words.slice(0, fits - 1) + "…" : String(at + 1);
      if (width > 10) {
        const style = key.text ? "label" : "label empty";
        parts.push(make("text", { class: style, x: left + 6, y: 4 + BAND / 2 + 4 }, said));
      }
      begin = key.frame;
    });
    episode.keyframes.forEach((key, at) => parts.push(this.handle(key, at, bottom)));
    this.head = make("line", { class: "head", y1: 0, y2: bottom });
    svg.replaceChildren(...parts, this.head);
    this.setFrame(this.frame);
  }

  handle(key, at, bottom) {
    const x = this.x(key.frame), last = at === this.episode.keyframes.length - 1;
    const named = ["key", last && "last", at === this.chosen && "chosen"].filter(Boolean).join(" ");
    const said = last ? "The last frame is always a keyframe" : `Keyframe ${at + 1}, frame ${key.frame}: drag to move`;
    const y1 = BAND + 4;
    return make("g", { class: named, "data-at": at },
      make("title", {}, said),
      make("line", { x1: x, x2: x, y1, y2: bottom }),
      make("path", { d: `M${x - 7},${y1 + 1}h14v6l-7,8l-7,-8z` }),
      make("line", { class: "grip", x1: x, x2: x, y1, y2: bottom }));
  }

  // A press on a keyframe drags it, with its picture shown on the way; on anything else it scrubs.
  press(event) {
    if (event.button !== 0 || !this.episode) return;
    const group = event.target.closest(".key"), at = group ? Number(group.dataset.at) : -1;
    const keyframes = this.episode.keyframes, grabbed = at >= 0 && at < keyframes.length - 1;
    const low = at > 0 ? keyframes[at - 1].frame + 1 : 1, high = grabbed ? keyframes[at + 1].frame - 1 : 0;
    const from = grabbed ? keyframes[at].frame : 0;
    let moved = false;
    if (at >= 0) {
      this.choose(at);
      this.seek(keyframes[at].frame);
    } else {
      const frame = this.frameAt(event);
      if (event.offsetY < BAND + 4) this.choose(keyframes.findIndex((key) => key.frame >= frame));
      this.seek(frame);
    }
    const drag = (next) => {
      const frame = this.frameAt(next);
      if (!moved && Math.abs(next.clientX - event.clientX) < 3) return;
      moved = true;
      if (!grabbed) return this.seek(frame);
      keyframes[at].frame = Math.max(low, Math.min(high, frame));
      this.draw();
      this.seek(keyframes[at].frame);
    };
    const drop = () => {
      removeEventListener("pointermove", drag);
      removeEventListener("pointerup", drop);
      removeEventListener("pointercancel", drop);
      if (grabbed && keyframes[at].frame !== from) this.move(from, keyframes[at].frame);
    };
    addEventListener("pointermove", drag);
    addEventListener("pointerup", drop);
    addEventListener("pointercancel", drop);
  }
}
