// The page: which episode is shown, what was corrected, and the keys.

import { Player } from "/static/player.js";
import { Segments } from "/static/segments.js";
import { Timeline } from "/static/timeline.js";

const at = (id) => document.getElementById(id);
const AGAIN = 1500; // milliseconds until an unanswered correction is sent again
let dataset, episode, chosen = 0, queue = Promise.resolve(), waiting = 0;

function note(text) {
  at("note").textContent = text;
  at("note").hidden = !text;
}

function saved(text, style = "") {
  at("saved").textContent = text;
  at("saved").className = style;
}

async function ask(address, body = null) {
  const post = { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) };
  const answer = await fetch(address, body === null ? {} : post);
  const told = await answer.json().catch(() => ({ wrong: `Expected an answer, got status ${answer.status}.` }));
  if (told.wrong) throw new Error(told.wrong);
  return told;
}

// Corrections go one after another; while llakey label does not answer, they wait for it to be started again.
function send(address, body) {
  waiting++;
  saved("saving …");
  queue = queue.then(async () => {
    for (;;) {
      try {
        const told = await ask(address, body);
        note("");
        return told;
      } catch (error) {
        if (!(error instanceof TypeError)) throw error;
        saved("not saved yet", "wrong");
        note("llakey label does not answer: start the same command again, with the same --port. The page then goes on.");
        await new Promise((done) => setTimeout(done, AGAIN));
      }
    }
  }).then(taken, async (error) => {
    note(error.message);
    await open(episode.episode, true);
  }).finally(() => {
    if (--waiting === 0) saved(`saved in ${dataset.file.split("/").pop()}`, "done");
  });
  return queue;
}

// What a correction changed; texts that are being typed meanwhile stay.
async function taken(told) {
  const listed = dataset.episodes.findIndex((one) => one.episode === told.episode);
  dataset.episodes[listed] = { episode: told.episode, task: told.task, complete: told.complete };
  if (told.episode !== episode.episode) return open(told.episode);
  Object.assign(episode, told);
  show();
}

const correct = (what) => send(`/episodes/${episode.episode}/corrections`, what);

function show(anew = false) {
  chosen = Math.max(0, Math.min(chosen, episode.keyframes.length - 1));
  timeline.show(episode, chosen);
  segments.show(episode, chosen, anew);
  const done = dataset.episodes.filter((one) => one.complete).length, all = dataset.episodes.length;
  at("bar").style.width = `${(100 * done) / all}%`;
  at("count").textContent = `${done} of ${all} episodes complete`;
  at("episode").replaceChildren(...dataset.episodes.map((one) => {
    const option = new Option(`${one.complete ? "✓" : "○"} ${one.episode}: ${one.task}`, one.episode);
    option.selected = one.episode === episode.episode;
    return option;
  }));
  const empty = episode.keyframes.some((key) => !key.text);
  at("fill").hidden = episode.alike === null || !empty;
  at("fill").textContent = `Fill the empty ones as in episode ${episode.alike}`;
  at("remove").disabled = at("here").disabled = chosen === episode.keyframes.length - 1;
}

function choose(place) {
  chosen = place;
  timeline.show(episode, chosen);
  segments.rows.forEach((row, one) => row.card.classList.toggle("chosen", one === chosen));
  at("remove").disabled = at("here").disabled = chosen === episode.keyframes.length - 1;
}

async function open(number, stay = false) {
  const frame = player.frame;
  episode = await ask(`/episodes/${number}`);
  history.replaceState(null, "", `#${number}`);
  at("task").textContent = episode.task;
  if (!stay) {
    chosen = 0;
    player.open(number, episode.frames, episode.fps, dataset.cameras, dataset.run);
  } else player.seek(frame);
  show(true);
}

function step(by) {
  const place = dataset.episodes.findIndex((one) => one.episode === episode.episode) + by;
  if (dataset.episodes[place]) open(dataset.episodes[place].episode);
}

function playSegment(place) {
  player.play(place ? episode.keyframes[place - 1].frame : 0, episode.keyframes[place].frame);
}

function toKeyframe(by) {
  const frames = episode.keyframes.map((key) => key.frame);
  const place = by > 0 ? frames.findIndex((one) => one > player.frame) : frames.findLastIndex((one) => one < player.frame);
  if (place >= 0) choose(place);
  player.pause();
  player.seek(place >= 0 ? frames[place] : by > 0 ? episode.frames - 1 : 0);
}

const add = (frame) => correct({ do: "add", frame }).then(() => choose(Math.max(0, episode.keyframes.findIndex((key) => key.frame >= frame))));
const remove = (place) => correct({ do: "remove", frame: episode.keyframes[place].frame });
const move = (frame, to) => correct({ do: "move", frame, to });
const here = () => move(episode.keyframes[chosen].frame, player.frame);

const player = new Player(at("cameras"), {
  shown: (frame) => {
    timeline.setFrame(frame);
    if (episode) at("clock").textContent = `${(frame / episode.fps).toFixed(2)} s · frame ${frame} of ${episode.frames - 1}`;
  },
  ended: (playing) => { at("play").textContent = playing ? "Pause" : "Play"; },
  failed: async (address) => note(await fetch(address).then((answer) => (answer.ok ? "" : answer.text()), () => "A picture cannot be had: is llakey label running?")),
});
const timeline = new Timeline(at("timeline"), {
  seek: (frame) => { player.pause(); player.seek(frame); }, choose, move, add,
});
const segments = new Segments(at("segments"), {
  choose, remove, play: playSegment,
  say: (frame, text) => correct({ do: "say", frame, text }),
  suggest: (segment, text) => ask(`/episodes/${episode.episode}/suggestions?${new URLSearchParams({ segment, text })}`).catch(() => ({ valid: true, texts: [], forms: [] })),
});

const toggle = () => (player.playing ? player.pause() : player.play());
const presses = {
  before: () => step(-1), after: () => step(1), play: toggle, undo: () => send("/undo", {}), redo: () => send("/redo", {}),
  add: () => add(player.frame), here, remove: () => remove(chosen),
  fill: () => correct({ do: "fill", source: episode.alike }),
};
for (const [id, press] of Object.entries(presses)) {
  at(id).addEventListener("click", () => { press(); if (id !== "fill") at(id).blur(); });
}
at("episode").addEventListener("change", () => open(Number(at("episode").value)));
at("rate").addEventListener("change", () => player.setRate(Number(at("rate").value)));

const keys = {
  " ": toggle, ArrowLeft: (event) => player.seek(player.frame - (event.shiftKey ? 10 : 1)),
  ArrowRight: (event) => player.seek(player.frame + (event.shiftKey ? 10 : 1)),
  "[": () => toKeyframe(-1), "]": () => toKeyframe(1), k: () => add(player.frame), m: here,
  Delete: () => at("remove").disabled || remove(chosen), n: () => step(1), p: () => step(-1),
};
addEventListener("keydown", (event) => {
  if (!episode || event.target.closest("input, select")) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if ((event.ctrlKey || event.metaKey) && key === "z") send(event.shiftKey ? "/redo" : "/undo", {});
  else if (keys[key] && !event.ctrlKey && !event.metaKey && !event.altKey) keys[key](event);
  else return;
  event.preventDefault();
});
addEventListener("beforeunload", (event) => { if (waiting) event.preventDefault(); });

dataset = await ask("/dataset");
at("repo").textContent = dataset.repo_id;
document.title = `${dataset.repo_id} · llakey label`;
const named = dataset.episodes.find((one) => String(one.episode) === location.hash.slice(1));
const first = named ?? dataset.episodes.find((one) => !one.complete) ?? dataset.episodes[0];
await open(first.episode);
saved(dataset.file.split("/").pop());
