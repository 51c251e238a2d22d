"use strict";
// The editor of a seat: keeps the text, runs the program, shows its output. All output is set as text, never as HTML.

const SAVE_AFTER = 800; // milliseconds after the last key
const LOOK_RUNNING = 250, LOOK_IDLE = 1000;
const MOST_SHOWN = 2000; // lines

const place = id => document.getElementById(id);
let editing = null;
let version = 0; // of the text that this page has, or has sent
let isDirty = false; // the text has changes that are not sent
let saver = 0;
let run = 0, next = 0; // the run whose output is shown, and the first line of it that is not here yet
let isRunning = false, isStarting = false;
let most = 0; // bytes of a program

async function postJson(path, body) {
  const answer = await fetch(path, { method: "POST", body, signal: AbortSignal.timeout(LONGEST) });
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
}

// Sends the text; the server would close the connection of a longer one before it has read all of it.
async function sendText(what) {
  const text = new TextEncoder().encode(editing.text());
  if (text.length > most) throw new Error(`The program is too long: it has ${text.length} bytes, and at most ${most} are allowed.`);
  return postJson(`/seat/${number}/${what}`, text);
}

function note(text) {
  place("saved").textContent = text;
}

function changed() {
  isDirty = true;
  note("");
  editing.mark(0);
  clearTimeout(saver);
  saver = setTimeout(() => tried(save), SAVE_AFTER);
}

async function save() {
  clearTimeout(saver);
  if (!isDirty) return;
  isDirty = false;
  try {
    version = (await sendText("program")).version;
    note("saved");
  } catch (error) {
    isDirty = true;
    throw error;
  }
}

// Another window of this seat has saved a text. It comes here too, unless this window has changes, which then win.
async function follow(newest) {
  if (newest <= version) return;
  if (isDirty) {
    version = newest;
    note("Another window changed the program too. The text of this window counts now.");
    return;
  }
  const found = await fetchJson(`/seat/${number}/program`);
  if (isDirty || found.version <= version) return;
  version = found.version;
  if (found.text !== editing.text()) {
    editing.set(found.text);
    note("Another window changed the program.");
  }
}

async function start() {
  if (isRunning || !editing) return;
  clearTimeout(saver);
  isDirty = false;
  editing.mark(0);
  showStatus("starts", "running");
  setRunning(true);
  isStarting = true;
  try {
    const started = await sendText("run");
    version = started.version;
    begin(started.run);
    note("saved");
  } catch (error) {
    isDirty = true;
    setRunning(false);
    showStatus("", "");
    throw error;
  } finally {
    isStarting = false;
  }
}

async function stop() {
  place("stop").disabled = true;
  await postJson(`/seat/${number}/stop`);
}

function begin(newer) {
  run = newer;
  next = 0;
  place("output").replaceChildren();
  place("left-out").textContent = "";
}

function setRunning(isNow) {
  isRunning = isNow;
  place("run").disabled = isNow;
  place("stop").disabled = !isNow;
}

function showStatus(text, kind) {
  place("how").textContent = text;
  place("how").className = kind;
}

function addLine(text, kind = "") {
  const line = document.createElement("div");
  line.textContent = text;
  line.className = kind;
  place("output").append(line);
}

function showOutput(output) {
  const list = place("output");
  const isAtEnd = list.scrollHeight - list.scrollTop - list.clientHeight < 40;
  list.querySelector(".open-line")?.remove();
  if (output.first > next) place("left-out").textContent = "earlier lines are left out";
  for (const line of output.lines) addLine(line);
  next = output.first + output.lines.length;
  if (output.open) addLine(output.open, "open-line");
  while (list.childElementCount > MOST_SHOWN) list.firstElementChild.remove();
  if (isAtEnd) list.scrollTop = list.scrollHeight;
}

// Shows how the shown run has ended, once.
function showEnd(found) {
  setRunning(false);
  const seconds = `after ${found.seconds.toFixed(1)} s`;
  const isGood = found.exit_code === 0;
  addLine(`— ${found.ended} ${seconds}`, "end");
  place("output").scrollTop = place("output").scrollHeight;
  if (found.error) {
    showStatus(`line ${found.error.line}: ${found.error.text}`, "wrong");
    editing.mark(found.error.line, found.error.text);
  } else {
    showStatus(`${found.ended} ${seconds}`, isGood ? "" : "wrong");
  }
}

async function lookAtRun() {
  const wasRunning = isRunning;
  if (isStarting) return;
  const view = isIn3d ? "&view=1" : "";
  const found = await fetchJson(`/seat/${number}/output?run=${run}&from=${next}${view}`);
  if ("view" in found) noteView(found.view);
  await follow(found.version);
  if (isStarting || found.run < run && found.run) return; // the output is that of the run before
  if (!found.run) {
    if (isRunning) showStatus("the program has ended with the page of the class", "wrong");
    setRunning(false);
    return;
  }
  const isNew = found.run !== run;
  if (isNew) begin(found.run);
  const isOver = found.ended !== null;
  if (!isOver) {
    setRunning(true);
    showStatus(`runs for ${found.seconds.toFixed(0)} s`, "running");
  }
  showOutput(found.output);
  if (found.output.has_more) return lookAtRun();
  if (isOver && (wasRunning || isNew || isRunning)) showEnd(found);
}

// `repeat` waits the shorter pause; without a run most of its turns do nothing.
let idleUntil = 0;
async function lookInTime() {
  if (!isRunning && performance.now() < idleUntil) return;
  await lookAtRun();
  idleUntil = performance.now() + LOOK_IDLE;
}

async function open() {
  const settings = await fetchJson(`/seat/${number}/editor`);
  const program = await fetchJson(`/seat/${number}/program`);
  version = program.version;
  most = settings.most_text;
  place("name").textContent = program.name;
  const missing = Object.entries(settings.missing).map(([what, text]) =>
    what === "view" ? `For a 3-D view, on the teacher's computer: ${text}` : `For an editor with colours, on the teacher's computer: ${text}`);
  place("editor-hint").textContent = missing.join(" ");
  place("editor-hint").hidden = !missing.length;
  editing = await makeEditing(settings.component, place("text"), program.text, changed, () => tried(start));
  place("run").disabled = false;
  if (settings.has_view) {
    tabs.view.hidden = false;
    showView();
  }
  repeat(lookInTime, LOOK_RUNNING);
}

place("run").addEventListener("click", () => tried(start));
place("stop").addEventListener("click", () => tried(stop));
place("clear").addEventListener("click", () => place("output").replaceChildren());
addEventListener("pagehide", () => {
  if (isDirty && editing) fetch(`/seat/${number}/program`, { method: "POST", body: editing.text(), keepalive: true });
});
document.addEventListener("keydown", event => {
  if (event.key === "Enter" && (event.ctrlKey || event.metaKey) && !event.defaultPrevented) tried(start);
});
tried(open);
