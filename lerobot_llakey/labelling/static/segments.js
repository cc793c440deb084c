// The list of segments: one instruction each, with what may be meant while it is typed.

import { COLOURS } from "/static/timeline.js";

const PAUSE = 300; // milliseconds without a key until what was typed is saved
const SLOT = /<[^>]+>/;

function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in node) node[key] = value;
    else node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
}

export class Segments {
  constructor(place, actions) { // actions: choose, play, remove, say, suggest
    Object.assign(this, { place, ...actions, rows: [] });
    document.addEventListener("pointerdown", (event) => {
      if (!event.target.closest(".segment")) this.close();
    });
  }

  show(episode, chosen, anew) {
    this.episode = episode;
    if (anew || this.rows.length !== episode.keyframes.length) {
      this.close();
      this.rows = episode.keyframes.map((_, at) => this.row(at));
      this.place.replaceChildren(...this.rows.map((row) => row.card));
    }
    let begin = 0;
    episode.keyframes.forEach((key, at) => {
      const row = this.rows[at];
      row.card.className = ["segment", at === chosen && "chosen"].filter(Boolean).join(" ");
      row.time.textContent = `${(begin / episode.fps).toFixed(1)} – ${(key.frame / episode.fps).toFixed(1)} s`;
      row.jaw.textContent = key.open ? "gripper open" : "gripper closed";
      row.jaw.className = key.open ? "jaw open" : "jaw";
      row.remove.hidden = at === episode.keyframes.length - 1;
      if (document.activeElement !== row.input || anew) row.input.value = key.text;
      this.judge(at, key.valid);
      begin = key.frame;
    });
  }

  row(at) {
    const row = {
      time: element("span"), jaw: element("span"), wrong: element("div", { className: "wrong", hidden: true }),
      play: element("button", { textContent: "▶", title: "Play this segment (Ctrl+Space)" }),
      remove: element("button", { textContent: "✕", title: "Delete the keyframe that ends this segment" }),
      input: element("input", { type: "text", placeholder: "what is done here?", maxLength: 400, autocomplete: "off" }),
    };
    row.input.setAttribute("aria-label", `Instruction of segment ${at + 1}`);
    row.play.setAttribute("aria-label", `Play segment ${at + 1}`);
    row.remove.setAttribute("aria-label", `Delete keyframe ${at + 1}`);
    const space = element("span", { className: "space" });
    const top = element("div", { className: "top" }, element("b", { textContent: at + 1 }), row.time, row.jaw, space,
      row.play, row.remove);
    row.card = element("div", {}, top, row.input, row.wrong);
    row.card.style.setProperty("--colour", COLOURS[at % COLOURS.length]);
    row.card.addEventListener("pointerdown", () => this.choose(at));
    row.play.addEventListener("click", () => this.play(at));
    row.remove.addEventListener("click", () => this.remove(at));
    row.input.addEventListener("focus", () => { this.choose(at); this.offer(at); });
    row.input.addEventListener("input", () => { this.later(at); this.offer(at); });
    row.input.addEventListener("blur", () => this.save(at));
    row.input.addEventListener("keydown", (event) => this.key(event, at));
    return row;
  }

  later(at) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.save(at), PAUSE);
  }

  save(at) {
    clearTimeout(this.timer);
    const key = this.episode.keyframes[at], row = this.rows[at];
    const text = row.input.value.trim().replace(/\s+/g, " ");
    if (key === undefined || text === key.text) return;
    key.text = text;
    this.say(key.frame, text);
  }

  // Forms that come nearest to a text outside the grammar stand below it.
  async judge(at, valid, forms = null) {
    const row = this.rows[at], text = row.input.value.trim(), wrong = text !== "" && !valid;
    row.card.classList.toggle("invalid", wrong);
    row.wrong.hidden = !wrong;
    if (!wrong) return;
    forms ??= (await this.suggest(at, text)).forms;
    const buttons = forms.map((form) => {
      const button = element("button", { textContent: form, type: "button" });
      button.addEventListener("click", () => this.take(at, form));
      return button;
    });
    row.wrong.replaceChildren("Outside the grammar. Nearest: ", ...buttons);
  }

  async offer(at) {
    const row = this.rows[at], text = row.input.value, asked = (this.asked = {});
    const found = await this.suggest(at, text);
    if (this.asked !== asked || document.activeElement !== row.input) return; // something else was typed since
    this.judge(at, found.valid, found.forms);
    this.close();
    const offers = [...found.texts.map((one) => [one, "offer"]), ...(text ? [] : found.forms.map((one) => [one, "offer form"]))];
    if (!offers.length) return;
    this.list = element("div", { className: "offers" });
    if (found.texts.length) this.list.append(element("small", { textContent: "said before" }));
    for (const [one, style] of offers) {
      if (style === "offer form" && !this.list.querySelector(".form")) {
        this.list.append(element("small", { textContent: "forms of the grammar" }));
      }
      const button = element("button", { textContent: one, className: style, type: "button", tabIndex: -1 });
      button.addEventListener("pointerdown", (event) => { event.preventDefault(); this.take(at, one); });
      this.list.append(button);
    }
    row.card.append(this.list);
  }

  close() {
    this.list?.remove();
    this.list = null;
  }

  take(at, text) {
    const { input } = this.rows[at], slot = text.match(SLOT);
    input.value = text;
    input.focus();
    if (slot) input.setSelectionRange(slot.index, slot.index + slot[0].length);
    this.close();
    if (!slot) this.save(at);
    else this.judge(at, false, []);
  }

  key(event, at) {
    const offers = this.list ? [...this.list.querySelectorAll(".offer")] : [];
    const now = offers.findIndex((one) => one.classList.contains("chosen"));
    if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      event.preventDefault();
      if (!offers.length) return void this.offer(at);
      const next = event.key === "ArrowDown" ? Math.min(now + 1, offers.length - 1) : Math.max(now - 1, -1);
      offers.forEach((one, place) => one.classList.toggle("chosen", place === next));
      offers[next]?.scrollIntoView({ block: "nearest" });
    } else if (event.key === "Enter") {
      if (now >= 0) return void this.take(at, offers[now].textContent);
      this.save(at);
      const next = this.rows[at + 1];
      next ? next.input.focus() : this.rows[at].input.blur();
      if (!next) this.close();
    } else if (event.key === "Escape") {
      if (this.list) this.close();
      else this.rows[at].input.blur();
    } else if (event.key === " " && event.ctrlKey) {
      event.preventDefault();
      this.play(at);
    } else if (event.key === "Tab") this.close();
  }
}
