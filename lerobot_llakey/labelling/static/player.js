// Pictures of all cameras, frame by frame: seeking, playing, and fetching ahead.

const AHEAD = 30, KEPT = 120; // frames

export class Player {
  constructor(place, { shown, ended, failed }) {
    Object.assign(this, { place, shown, ended, failed, frame: 0, playing: false, rate: 1, cameras: [], aspect: 4 / 3 });
    this.pictures = new Map(); // frame -> one Image a camera, each with ready
    new ResizeObserver(() => this.arrange()).observe(place);
  }

  open(episode, frames, fps, cameras, run) {
    this.pause();
    this.pictures.clear();
    Object.assign(this, { episode, frames, fps, cameras, run, frame: 0, busy: false });
    this.canvases = cameras.map((camera) => {
      const figure = document.createElement("figure"), caption = document.createElement("figcaption");
      caption.textContent = camera;
      figure.append(document.createElement("canvas"), caption);
      return figure;
    });
    this.place.replaceChildren(...this.canvases);
    this.arrange();
    this.seek(0);
  }

  // As many columns as let the pictures be largest.
  arrange() {
    const { clientWidth: width, clientHeight: height } = this.place, count = Math.max(this.cameras.length, 1);
    const size = (columns) => Math.min(width / columns / this.aspect, height / Math.ceil(count / columns));
    const columns = [...Array(count).keys()].map((one) => one + 1).sort((a, b) => size(b) - size(a))[0];
    this.place.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
  }

  seek(frame) {
    this.frame = Math.max(0, Math.min(this.frames - 1, Math.round(frame)));
    this.began = null;
    this.show();
  }

  show() {
    this.shown(this.frame);
    if (this.isReady(this.frame)) {
      this.draw(this.frame);
      if (!this.playing) this.ahead(3);
    } else if (!this.busy) { // while scrubbing, only the frame that is wanted last is fetched
      const episode = this.episode;
      this.busy = true;
      this.fetch(this.frame).then(() => {
        if (this.episode !== episode) return;
        this.busy = false;
        this.show();
      });
    }
  }

  isReady(frame) {
    const images = this.pictures.get(frame);
    return this.cameras.length === 0 || (images !== undefined && images.every((image) => image.ready));
  }

  fetch(frame) {
    let images = this.pictures.get(frame);
    if (images === undefined) {
      images = this.cameras.map((camera) => {
        const image = new Image();
        image.src = `/episodes/${this.episode}/pictures/${encodeURIComponent(camera)}/${frame}?run=${this.run}`;
        image.done = image.decode().catch(() => this.failed(image.src)).then(() => { image.ready = true; });
        return image;
      });
      this.pictures.set(frame, images);
      for (const old of this.pictures.keys()) {
        if (this.pictures.size <= KEPT) break;
        if (Math.abs(old - this.frame) > AHEAD) this.pictures.delete(old);
      }
    }
    return Promise.all(images.map((image) => image.done));
  }

  ahead(count) {
    for (let next = this.frame + 1; next <= Math.min(this.frame + count, this.frames - 1); next++) this.fetch(next);
  }

  draw(frame) {
    (this.pictures.get(frame) ?? []).forEach((image, at) => {
      if (!image.naturalWidth) return;
      const canvas = this.canvases[at].firstChild;
      if (canvas.width !== image.naturalWidth || canvas.height !== image.naturalHeight) {
        canvas.width = image.naturalWidth;
        canvas.height = image.naturalHeight;
        this.aspect = canvas.width / canvas.height;
        this.arrange();
      }
      canvas.getContext("2d").drawImage(image, 0, 0);
    });
  }

  play(from = null, until = null) {
    if (from !== null) this.seek(from);
    else if (this.frame >= this.frames - 1) this.seek(0);
    this.until = until ?? this.frames - 1;
    this.began = null;
    if (this.playing) return;
    this.playing = true;
    const tick = (now) => {
      if (!this.playing) return;
      this.ahead(AHEAD);
      if (this.began === null || !this.isReady(this.frame)) this.began = { now, frame: this.frame };
      let due = Math.floor(this.began.frame + ((now - this.began.now) / 1000) * this.fps * this.rate);
      due = Math.min(due, this.until);
      while (due > this.frame && !this.isReady(due)) due--; // hold rather than leave the pictures behind
      if (due > this.frame) {
        this.frame = due;
        this.show();
      }
      if (this.frame >= this.until) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    this.ended(true);
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.ended(false);
  }

  setRate(rate) {
    this.rate = rate;
    this.began = null;
  }
}
